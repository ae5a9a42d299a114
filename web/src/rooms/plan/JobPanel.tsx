import { useMemo, useState } from 'react';

import type { Job } from '../../model/types';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useJobRows } from '../jobs/useJob';
import { JobWord } from './FileList';
import type { Place } from './place';
import { progressOf, toldBy, type Trouble } from './progress';
import { CommandLine, StepTable } from './StepTable';
import type { PlanTexts } from './usePlanTexts';

/** A plan that is carried out: each step, what went wrong as one tree, and what may be done about it. All pages see the same. */
export function JobPanel({ texts, job, onGo }: { texts: PlanTexts; job: Job; onGo: (to: Partial<Place>) => void }) {
  const { api, canChange } = useEditor();
  const { rows, error } = useJobRows(job.id);
  const { plan, request, lines } = useMemo(() => toldBy(rows), [rows]);
  const [said, setSaid] = useState('');
  const post = (path: string, body: object, take: (answer: Job) => void) => void api.post<Job>(path, body).then(take, (failure: unknown) => setSaid(sentence(failure)));
  const stop = () => {
    setSaid(texts.stopping);
    post(`/api/jobs/${encodeURIComponent(job.id)}/stop`, {}, () => undefined);
  };
  if (error) return <p className="error" role="alert">{error}</p>;
  if (!plan || !request) return <p className="empty">{texts.loading}</p>;
  const { states, done, trouble, notes } = progressOf(plan, lines, job);
  const all = states.size - plan.steps.filter((step) => step.kind === 'check').length;
  const count = Math.max(0, Math.min(all, done - plan.steps.filter((step) => step.kind === 'check' && states.get(step.number) === 'held').length));
  const isOver = job.status !== null;
  return (
    <section aria-label={job.text}>
      <div className="row">
        <JobWord texts={texts} job={job} />
        <progress max={all || 1} value={isOver && job.status === 0 ? all || 1 : count} aria-label={texts.of(count, all)} />
        <span role="status">{texts.of(count, all)}</span>
        {!isOver && <button type="button" className="danger" disabled={!canChange || said !== ''} onClick={stop}>{texts.stop}</button>}
        {isOver && job.status !== 0 && <button type="button" className="primary" disabled={!canChange} onClick={() => post('/api/plans/start', request, (next) => onGo({ tab: 'job', of: next.id }))}>{texts.retry}</button>}
        {isOver && <button type="button" onClick={() => onGo({ tab: 'do', of: request.file })}>{texts.back}</button>}
        {said && !(isOver && said === texts.stopping) && <span className="note">{said}</span>}
      </div>
      <CommandLine texts={texts} command={job.command} />
      {trouble && <section className="trouble" role="alert"><h3>{texts.trouble}</h3><ul><Branch trouble={trouble} /></ul></section>}
      {notes.length > 0 && <details><summary>{texts.notes}</summary><ul>{notes.map((note, index) => <li key={index}>{note}</li>)}</ul></details>}
      <StepTable texts={texts} plan={plan} states={states} />
    </section>
  );
}

function Branch({ trouble }: { trouble: Trouble }) {
  return <li>{trouble.text}{trouble.below.length > 0 && <ul>{trouble.below.map((one, index) => <Branch key={index} trouble={one} />)}</ul>}</li>;
}
