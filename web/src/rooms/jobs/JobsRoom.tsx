import { useState } from 'react';

import type { Job } from '../../model/types';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { RoomProps } from '../../shell/rooms';
import { useRoomTexts } from '../../texts';
import { jobsTexts as en } from '../../texts/en/jobs';
import { jobsTexts as ja } from '../../texts/ja/jobs';
import './jobs.css';
import { ChangeList } from './ChangeList';
import { useJobRows } from './useJob';

/** More rows than these nobody reads. */
const SHOWN = 500;
/** The signal of Ctrl-C, which ends a job that is stopped. */
const INTERRUPT = 2;

/** Commands that go on for some time: what they are, what they have told, and their end. Below is all that was changed. */
export default function JobsRoom({ system, view }: RoomProps) {
  const texts = useRoomTexts({ en, ja });
  const { show } = useEditor();
  const job = system.jobs.get(view.of);
  return (
    <main className="room jobs" aria-labelledby="jobs-title">
      <h2 id="jobs-title">{texts.title}</h2>
      {job ? (
        <>
          <button type="button" onClick={() => show('jobs')}>{texts.all}</button>
          <OneJob key={job.id} job={job} />
        </>
      ) : system.jobs.size === 0 ? <p className="empty">{texts.none}</p> : (
        <table>
          <thead><tr><th>{texts.which}</th><th>{texts.status}</th><th>{texts.rows}</th><td /></tr></thead>
          <tbody>
            {[...system.jobs.values()].reverse().map((one) => (
              <tr key={one.id}>
                <td><button type="button" className="link" onClick={() => show('jobs', one.id)}>{one.text}</button><br /><code>{one.command}</code></td>
                <td><JobStatus job={one} /></td>
                <td>{one.count}</td>
                <td><StopButton job={one} /></td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      {!job && <ChangeList />}
    </main>
  );
}

/** What one job is, what it has told, and how it ended. */
function OneJob({ job }: { job: Job }) {
  const texts = useRoomTexts({ en, ja });
  const { first, rows, error } = useJobRows(job.id);
  const shown = rows.slice(-SHOWN);
  const earlier = first + rows.length - shown.length;
  return (
    <section aria-label={job.text}>
      <h3>{job.text}</h3>
      <p><code>{job.command}</code> <JobStatus job={job} /> <StopButton job={job} /></p>
      {(job.error || error) && <p className="bad" role="alert">{job.error || error}</p>}
      {earlier > 0 && <p>{texts.earlier(earlier)}</p>}
      {shown.length === 0 ? <p className="empty">{texts.noRows}</p> : <pre>{shown.map((row) => JSON.stringify(row)).join('\n')}</pre>}
    </section>
  );
}

function JobStatus({ job }: { job: Job }) {
  const texts = useRoomTexts({ en, ja });
  return <span className="status">{job.status === null ? texts.runs : job.status === 0 ? texts.done : job.status === -INTERRUPT ? texts.stopped : texts.failed(job.status)}</span>;
}

/** Stops a job as Ctrl-C does: it ends as its command promises, which may take a while. */
export function StopButton({ job }: { job: Job }) {
  const texts = useRoomTexts({ en, ja });
  const { api } = useEditor();
  const [said, setSaid] = useState('');
  if (job.status !== null) return null;
  const stop = () => {
    setSaid(texts.stopping);
    api.post(`/api/jobs/${encodeURIComponent(job.id)}/stop`, {}).catch((error: unknown) => setSaid(sentence(error)));
  };
  return <>{said ? <span>{said}</span> : <button type="button" onClick={stop}>{texts.stop}</button>}</>;
}
