import { memo, useState, type ReactNode } from 'react';

import { matches } from '../model/search';
import type { TreeEvent } from '../model/types';
import { Icon } from '../parts/icons';
import { clock } from '../parts/numbers';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** More rows than these nobody reads; the filter looks through all that are kept. */
const SHOWN = 200;

/** What has happened, the newest first. A click selects the component. */
export const EventsPanel = memo(function EventsPanel({ events, children }: { events: readonly TreeEvent[]; children?: ReactNode }) {
  const texts = useTexts();
  const { reveal } = useEditor();
  const [filter, setFilter] = useState('');
  const [held, setHeld] = useState<readonly TreeEvent[] | null>(null);
  const source = held ?? events;
  const shown = source.filter((event) => matches(`${event.path} ${event.event} ${event.detail} ${event.kind}`, filter)).slice(-SHOWN).reverse();
  const missed = held ? countAfter(events, held.at(-1)) : 0;
  return (
    <section className="panel events" aria-labelledby="events-title">
      <div className="filters">
        <h2 id="events-title">{texts.events.title}</h2>
        <input type="search" aria-label={texts.events.filter} placeholder={texts.events.filter} value={filter} onChange={(event) => setFilter(event.target.value)} />
        <button type="button" aria-pressed={held !== null} onClick={() => setHeld(held ? null : events)}>
          <Icon name={held ? 'play' : 'pause'} />{held ? texts.events.resume : texts.events.pause}{missed > 0 && <span className="count">{texts.events.waiting(missed)}</span>}
        </button>
      </div>
      {children}
      {shown.length === 0 ? <p className="empty">{texts.events.none}</p> : (
        // A region that scrolls must be reachable by Tab, else it cannot be scrolled by keys.
        // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
        <div className="scroll" tabIndex={0} role="group" aria-labelledby="events-title">
          <table>
            <thead><tr><th>{texts.events.time}</th><th>{texts.events.path}</th><th>{texts.events.event}</th><th>{texts.events.detail}</th></tr></thead>
            <tbody>
              {shown.map((event, index) => (
                <tr key={`${event.time} ${event.path} ${event.event} ${index}`}>
                  <td className="time">{clock(event.time, true)}</td>
                  <td><button type="button" className="link" onClick={() => reveal(event.path)}>{event.path}</button></td>
                  <td>{event.event}</td>
                  <td>{event.detail}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
});

const countAfter = (events: readonly TreeEvent[], last: TreeEvent | undefined): number =>
  last ? events.length - 1 - events.lastIndexOf(last) : events.length;
