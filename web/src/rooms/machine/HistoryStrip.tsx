import { useState } from 'react';

import { clock } from '../../parts/numbers';
import { lastPassage } from './live';
import type { Entry } from './types';
import { useMachineTexts } from './useMachine';

const SHOWN = 200;

/** What happened, the newest first: all of it, or the transitions. */
export function HistoryStrip({ log }: { log: readonly Entry[] }) {
  const texts = useMachineTexts();
  const [isAll, setAll] = useState(false);
  const last = lastPassage(log);
  const rows = (isAll ? log : log.filter(([, , kind]) => ['transition', 'run', 'edited', 'failed', 'lost'].includes(kind))).slice(-SHOWN).reverse();
  return (
    <section className="history" aria-label={texts.log}>
      <header>
        <h2>{texts.log}</h2>
        <div className="group" role="group" aria-label={texts.log}>
          <button type="button" aria-pressed={!isAll} onClick={() => setAll(false)}>{texts.logTransitions}</button>
          <button type="button" aria-pressed={isAll} onClick={() => setAll(true)}>{texts.logAll}</button>
        </div>
        {last && (
          <span className="last" title={texts.last}>
            {texts.last}: <strong>{last.passage.from} → {last.passage.to}</strong> {last.passage.cause}{last.data && `on ${last.data}` !== last.passage.cause ? `, ${texts.withData(last.data)}` : ''} <span className="note">{texts.atTime(clock(last.time))}</span>
          </span>
        )}
      </header>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- What scrolls must be reached by keys. */}
      <div className="scroll" tabIndex={0} role="group" aria-label={texts.log}>
        {rows.length === 0 ? <p className="empty">{texts.noLog}</p> : (
          <table>
            <tbody>
              {rows.map(([number, time, kind, text]) => (
                <tr key={number} className={`entry-${kind}`}><td className="time">{clock(time, true)}</td><td className="kind">{texts.kinds[kind] ?? kind}</td><td>{text}</td></tr>
              ))}
            </tbody>
          </table>
        )}
      </div>
    </section>
  );
}
