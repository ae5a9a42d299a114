import { Fragment, useMemo, useState } from 'react';

import { lackingFor } from '../../model/rights';
import type { System } from '../../model/system';
import type { Job } from '../../model/types';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useJobRows } from '../jobs/useJob';
import { JobWord } from './FileList';
import type { Place } from './place';
import { progressOf, toldBy, type Trouble } from './progress';
import { CommandLine, StepTable } from './StepTable';
import { NEEDED } from './types';
import type { PlanTexts } from './usePlanTexts';

/** A plan that is carried out: each step, what went wrong as one tree, and what may be done about it. All pages see the same. */
export function JobPanel({ texts, system, job, onGo }: { texts: PlanTexts; system: System; job: Job; onGo: (to: Partial<Place>) => void }) {
  const { api, canChange } = useEditor();
  const { rows, error } = useJobRows(job.id);
  const { plan, request, parts: told, notes } = useMemo(() => toldBy(rows), [rows]);
  const [said, setSaid] = useState('');
  const post = (path: string, body: object, take: (answer: Job) => void) => void api.post<Job>(path, body).then(take, (failure: unknown) => setSaid(sentence(failure)));
  const stop = () => {
    setSaid(texts.stopping);
    post(`/api/jobs/${encodeURIComponent(job.id)}/stop`, {}, () => undefined);
  };
  if (error) return <p className="error" role="alert">{error}</p>;
  if (!plan || !request) return <p className="empty">{texts.loading}</p>;
  const { parts, done, all, trouble } = progressOf(told, job);
  const isOver = job.status !== null;
  return (
    <section aria-label={job.text}>
      <div className="row">
        <JobWord texts={texts} job={job} />
        <progress max={all || 1} value={isOver && job.status === 0 ? all || 1 : done} aria-label={texts.of(done, all)} />
        <span role="status">{texts.of(done, all)}</span>
        {!isOver && <button type="button" className="danger" disabled={!canChange || said !== ''} onClick={stop}>{texts.stop}</button>}
        {trouble && <button type="button" className="primary" title={texts.retryHint} disabled={!canChange || Boolean(lackingFor(system, NEEDED[request.do], new Set()))} onClick={() => post('/api/plans/start', request, (next) => onGo({ tab: 'job', of: next.id }))}>{texts.retry}</button>}
        {isOver && <button type="button" onClick={() => onGo({ tab: 'do', of: request.file })}>{texts.back}</button>}
        {said && !(isOver && said === texts.stopping) && <span className="note">{said}</span>}
      </div>
      <CommandLine texts={texts} command={job.command} />
      {trouble && <section className="trouble" role="alert"><h3>{texts.trouble}</h3><ul><Branch texts={texts} trouble={trouble} /></ul></section>}
      {notes.length > 0 && <details><summary>{texts.notes}</summary><ul>{notes.map((note, index) => <li key={index}>{note}</li>)}</ul></details>}
      {parts.map(({ steps, reason, news }, index) => (
        <Fragment key={index}>
          {reason && <h3>{texts.anew(reason)}</h3>}
          <StepTable texts={texts} steps={steps} news={news} />
        </Fragment>
      ))}
    </section>
  );
}

function Branch({ texts, trouble }: { texts: PlanTexts; trouble: Trouble }) {
  const { text, left, below } = trouble;
  return <li>{left === undefined ? text : texts.left(left)}{below.length > 0 && <ul>{below.map((one, index) => <Branch key={index} texts={texts} trouble={one} />)}</ul>}</li>;
}
