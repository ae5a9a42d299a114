import { useState } from 'react';

import { matches } from '../../model/search';
import type { AuditRecord } from '../../model/types';
import { clock } from '../../parts/numbers';
import { useEditor } from '../../shell/contexts';
import { useRoomTexts } from '../../texts';
import { jobsTexts as en } from '../../texts/en/jobs';
import { jobsTexts as ja } from '../../texts/ja/jobs';
import { useChanges } from './useChanges';

/** More rows than these nobody reads; the filter looks through all that are kept. */
const SHOWN = 200;

/** What pages and scripts have changed, the newest first: when, by whom, what, from which value to which. */
export function ChangeList() {
  const texts = useRoomTexts({ en, ja });
  const { values: { page } } = useEditor();
  const { changes, error } = useChanges();
  const [filter, setFilter] = useState('');
  const shown = changes.filter(({ by, text, command, old, new: since }) => matches([by, text, command, old, since].join(' '), filter)).slice(-SHOWN).reverse();
  const author = (change: AuditRecord) => (change.page === page ? texts.thisPage : change.by);
  return (
    <section className="changes" aria-labelledby="changes-title">
      <div className="filters">
        <h2 id="changes-title">{texts.changes}</h2>
        <input type="search" aria-label={texts.filter} placeholder={texts.filter} value={filter} onChange={(event) => setFilter(event.target.value)} />
      </div>
      {error && <p className="bad" role="alert">{error}</p>}
      {shown.length === 0 ? <p className="empty">{texts.noChange}</p> : (
        <table>
          <thead><tr><th>{texts.when}</th><th>{texts.by}</th><th>{texts.what}</th><th>{texts.was}</th><th>{texts.is}</th></tr></thead>
          <tbody>
            {shown.map((change) => (
              <tr key={change.id}>
                <td className="time">{clock(change.time, true)}</td>
                <td className="author">{author(change)}</td>
                <td>{change.text}{change.count > 1 && <span className="note"> {texts.values(change.count)}</span>}{change.error && <><br /><span className="bad">{texts.changeFailed(change.error)}</span></>}<br /><code>{change.command}</code></td>
                <td className="value">{change.old}</td>
                <td className="value">{change.error ? change.old : change.new}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </section>
  );
}
