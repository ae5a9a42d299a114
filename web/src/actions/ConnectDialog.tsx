import { useEffect, useState, type SyntheticEvent } from 'react';

import { NO_WISH, badLine, propertiesOf, type Wish } from '../model/connecting';
import { endText } from '../model/does';
import { pairsOf, portType, shortName, signed } from '../model/ports';
import { matches } from '../model/search';
import type { System } from '../model/system';
import { portEnd, portPath, type Action, type Connectable, type Port, type PortEnd } from '../model/types';
import { Modal } from '../parts/Modal';
import { sentence } from '../server/api';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { ConnectorOptions } from './ConnectorOptions';

interface Props { system: System; component: string; from: PortEnd | null; to: PortEnd | null }

/** Connects two ports: both given by a drag, or chosen here by name. */
export function ConnectDialog({ system, component, from, to }: Props) {
  const texts = useTexts();
  const { open, perform, canChange } = useEditor();
  const ports = system.components.get(component)?.ports ?? [];
  const [own, setOwn] = useState(from?.port ?? ports[0]?.name ?? '');
  const [far, setFar] = useState(to ? portPath(to) : '');
  const [name, setName] = useState('');
  const [wish, setWish] = useState<Wish>(NO_WISH);
  const source = { component, port: own };
  const ownPort = ports.find((port) => port.name === own);
  const wrongLine = badLine(wish.further);
  const close = () => open(null);
  const gone = [component, ...(to ? [to.component] : [])].find((id) => !system.components.has(id));

  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!far || wrongLine !== null || !canChange) return;
    close();
    // The out port is the source, from whichever end the user began.
    const ends: [string, string] = ownPort?.direction === 'in' ? [far, portPath(source)] : [portPath(source), far];
    const properties = ownPort?.direction === 'service' ? {} : propertiesOf(wish);
    // With an id from here the command that is shown is the one that runs.
    const action: Action = { do: 'connect', id: crypto.randomUUID(), source: ends[0], target: ends[1], properties, ...(name.trim() ? { name: name.trim() } : {}) };
    void perform([action], texts.label.connect(endText(portEnd(ends[0])), endText(portEnd(ends[1]))));
  };

  if (gone !== undefined) {
    return (
      <Modal title={texts.connect.title} className="connect" onClose={close}>
        <p className="error" role="alert">{texts.live.gone(shortName(gone))}</p>
        <footer><button type="button" onClick={close}>{texts.plan.cancel}</button></footer>
      </Modal>
    );
  }
  return (
    <Modal title={texts.connect.title} className="connect" onClose={close}>
      <form method="dialog" onSubmit={submit}>
        <label>{texts.connect.from}: <span className="note">{shortName(component)}</span>
          {/* The dialog opens for this choice: the focus belongs here. */}
          {/* eslint-disable-next-line jsx-a11y/no-autofocus */}
          <select value={own} autoFocus={!to} onChange={(event) => { setOwn(event.target.value); setFar(''); }}>
            {ports.map((port) => <option key={port.name} value={port.name}>{port.name} ({texts.directions[port.direction]}, {portType(port)})</option>)}
          </select>
        </label>
        <FarPorts key={own} from={portPath(source)} chosen={far} onChoose={setFar} />
        <label>{texts.connect.name} <input type="text" value={name} placeholder={texts.connect.nameHint} onChange={(event) => setName(event.target.value)} /></label>
        {ownPort?.direction === 'service' && far && <Pairs own={ownPort} far={portAt(far, system)} />}
        {ownPort?.direction !== 'service' && <ConnectorOptions wish={wish} onChange={setWish} wrongLine={wrongLine} />}
        <footer>
          <button type="button" onClick={close}>{texts.plan.cancel}</button>
          <button type="submit" className="primary" data-first={to ? '' : undefined} disabled={!far || wrongLine !== null || !canChange}>{texts.act.connect}</button>
        </footer>
      </form>
    </Modal>
  );
}

const portAt = (path: string, system: System): Port | undefined => {
  const end = portEnd(path);
  return system.components.get(end.component)?.ports.find((port) => port.name === end.port);
};

/** Which interfaces of two service ports will belong together: those of one type, of which one side provides what the other requires. */
function Pairs({ own, far }: { own: Port; far: Port | undefined }) {
  const words = useTexts().manage.wires;
  const pairs = pairsOf(own, far);
  return (
    <fieldset className="far-ports">
      <legend>{words.pairs}</legend>
      {pairs.length === 0 && <p className="empty">{words.noPairs}</p>}
      <ul>{pairs.map(([mine, its]) => <li key={`${mine.instance} ${its.instance}`}>{signed(mine)} — {signed(its)} <span className="note">{mine.type}</span></li>)}</ul>
      {pairs.length > 0 && <p className="note">{words.pairsHint}</p>}
    </fieldset>
  );
}

/** The ports that fit, by name; the others with the reason. */
function FarPorts({ from, chosen, onChoose }: { from: string; chosen: string; onChoose: (path: string) => void }) {
  const texts = useTexts();
  const { api } = useEditor();
  const [answer, setAnswer] = useState<Connectable[] | string | null>(null);
  const [filter, setFilter] = useState('');
  useEffect(() => {
    let isWanted = true;
    api.connectable(from).then(
      (ports) => isWanted && setAnswer(ports),
      (error: unknown) => isWanted && setAnswer(sentence(error)),
    );
    return () => {
      isWanted = false;
    };
  }, [api, from]);
  const known = Array.isArray(answer) ? answer.filter((port) => matches(port.path, filter)) : [];
  const fitting = known.filter((port) => !port.why);
  const unfit = known.filter((port) => port.why);
  return (
    <fieldset className="far-ports">
      <legend>{texts.connect.to}</legend>
      <input type="search" aria-label={texts.connect.filter} placeholder={texts.connect.filter} value={filter} onChange={(event) => setFilter(event.target.value)} />
      {answer === null && <p className="empty">{texts.connect.asking}</p>}
      {typeof answer === 'string' && <p className="error">{answer}</p>}
      {Array.isArray(answer) && fitting.length === 0 && <p className="empty">{texts.connect.none}</p>}
      <div className="options">
        {fitting.map(({ path, type }) => (
          <label key={path} title={path}>
            <input type="radio" name="far" value={path} checked={chosen === path} onChange={() => onChoose(path)} />
            {endText(portEnd(path))} <span className="note">{type}</span>
          </label>
        ))}
      </div>
      {unfit.length > 0 && (
        <details>
          <summary>{texts.connect.unfit(unfit.length)}</summary>
          <ul>{unfit.map(({ path, why }) => <li key={path} title={path}>{endText(portEnd(path))}: <span className="note">{why}</span></li>)}</ul>
        </details>
      )}
    </fieldset>
  );
}
