import { useCallback, useEffect, useState } from 'react';

import { Icon } from '../../parts/icons';
import { StateIcon } from '../../parts/StateIcon';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { MachineRow } from './types';
import { useMachineTexts } from './useMachine';

const LOOK_MS = 3000;
export const NEW = '+';

/** All state machines that live, on this host and on linked ones. */
export function Overview() {
  const texts = useMachineTexts();
  const { api, show, canChange } = useEditor();
  const [found, setFound] = useState<MachineRow[] | null>(null);
  const [problem, setProblem] = useState('');
  const look = useCallback(() => api.get<{ machines: MachineRow[] }>('/api/machines').then(
    ({ machines }) => { setFound(machines); setProblem(''); },
    (error: unknown) => setProblem(sentence(error)),
  ), [api]);
  useEffect(() => {
    void look();
    const timer = setInterval(() => document.visibilityState === 'visible' && void look(), LOOK_MS);
    return () => clearInterval(timer);
  }, [look]);
  return (
    <main className="room machines" aria-labelledby="machines-title">
      <header>
        <h2 id="machines-title">{texts.title}</h2>
        <button type="button" className="primary" disabled={!canChange} onClick={() => show('machine', NEW)}><Icon name="plus" />{texts.draw}</button>
      </header>
      {problem && <p className="error" role="alert">{problem}</p>}
      {found === null ? <p className="empty">{texts.asking}</p> : found.length === 0 ? <p className="empty">{texts.none}</p> : (
        <table>
          <thead><tr><th scope="col">{texts.name}</th><th scope="col">{texts.run}</th><th scope="col">{texts.state}</th></tr></thead>
          <tbody>
            {found.map((one) => (
              <tr key={one.id}>
                <th scope="row"><button type="button" className="link" onClick={() => show('machine', one.id)}>{one.id}</button></th>
                <td>{one.run in texts.runs ? <RunWord run={one.run as keyof typeof texts.runs} /> : <span className="warning">⚠ {one.run}</span>}</td>
                <td>{one.state}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </main>
  );
}

function RunWord({ run }: { run: 'stopped' | 'running' | 'paused' | 'done' }) {
  const texts = useMachineTexts();
  const look = ({ running: 'active', paused: 'inactive', stopped: 'created', done: 'unknown' } as const)[run];
  return <span className={`word look-${look}`}><StateIcon look={look} /> {texts.runs[run]}</span>;
}
