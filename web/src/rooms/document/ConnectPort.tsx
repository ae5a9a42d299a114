import { useEffect, useState } from 'react';

import type { System } from '../../model/system';
import { portEnd, portPath, type Connectable } from '../../model/types';
import { Modal } from '../../parts/Modal';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useDocumentTexts } from './useDocument';

interface Props { system: System; from: string; onFrom: (port: string) => void; onClose: () => void; onConnect: (source: string, target: string) => void }

/** Connects a port by keyboard: those that fit are buttons, of the others the reason is told. */
export function ConnectPort({ system, from, onFrom, onClose, onConnect }: Props) {
  const texts = useDocumentTexts();
  const { api } = useEditor();
  const [answer, setAnswer] = useState<{ from: string; ports: Connectable[] } | null>(null);
  const [problem, setProblem] = useState('');
  const component = system.components.get(portEnd(from).component);
  useEffect(() => {
    let isWanted = true;
    api.connectable(from).then((ports) => isWanted && setAnswer({ from, ports }), (error: unknown) => isWanted && setProblem(sentence(error)));
    return () => {
      isWanted = false;
    };
  }, [api, from]);
  const ports = answer?.from === from ? answer.ports : [];
  const [good, bad] = [ports.filter((one) => !one.why), ports.filter((one) => one.why)];
  return (
    <Modal title={texts.connectTitle(from)} className="connect document-connect" onClose={onClose}>
      <label>{texts.choosePort}
        <select value={from} onChange={(event) => onFrom(event.target.value)}>
          {component?.ports.map((port) => {
            const path = portPath({ component: component.id, port: port.name });
            return <option key={path} value={path}>{port.name} ({port.direction})</option>;
          })}
        </select>
      </label>
      {problem && <p className="error" role="alert">{problem}</p>}
      <h3>{texts.fits}</h3>
      {answer && good.length === 0 && <p className="empty">{texts.noneFits}</p>}
      <ul className="links">{good.map((one) => <li key={one.path}><button type="button" onClick={() => onConnect(from, one.path)}>{one.path}</button><span className="note">{one.type}</span></li>)}</ul>
      {bad.length > 0 && (
        <details>
          <summary>{texts.fitsNot(bad.length)}</summary>
          <ul className="links">{bad.map((one) => <li key={one.path}><code>{one.path}</code><span className="note">{one.why}</span></li>)}</ul>
        </details>
      )}
      <footer><button type="button" onClick={onClose}>{texts.cancel}</button></footer>
    </Modal>
  );
}
