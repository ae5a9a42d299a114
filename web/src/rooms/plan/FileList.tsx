import { useState, type SyntheticEvent } from 'react';

import type { Files, Job } from '../../model/types';
import { useEditor } from '../../shell/contexts';
import type { Place } from './place';
import type { PlanTexts } from './usePlanTexts';

interface Props { texts: PlanTexts; known: Files | null; jobs: readonly Job[]; place: Place; onGo: (to: Partial<Place>) => void; onSaved: () => void }

/** What plans are about: what lives, and the profiles in granted folders; then the plans that were begun. */
export function FileList({ texts, known, jobs, place, onGo, onSaved }: Props) {
  const tab = place.tab === 'job' ? 'do' : place.tab;
  const row = (file: string, name: string) => (
    <li key={file}>
      <button type="button" className="link" aria-current={place.tab !== 'job' && place.of === file} title={file} onClick={() => onGo({ tab, of: file })}>{name}</button>
    </li>
  );
  const folders = known?.folders ?? [];
  const short = (file: string) => {
    const folder = folders.find((one) => file.startsWith(`${one}/`));
    return folder === undefined ? file : file.slice(folder.length + 1);
  };
  return (
    <nav className="plans-files" aria-label={texts.files}>
      <ul>{row('', texts.live)}</ul>
      <h2>{texts.files}</h2>
      {known && (folders.length === 0 ? <p className="empty">{texts.noFolder}</p> : known.files.length === 0 && <p className="empty">{texts.noFiles}</p>)}
      <ul>{known?.files.map((file) => row(file, short(file)))}</ul>
      {folders[0] !== undefined && <SaveForm texts={texts} first={`${folders[0]}/system.yaml`} onSaved={onSaved} />}
      {jobs.length > 0 && <h2>{texts.jobs}</h2>}
      <ul>
        {[...jobs].reverse().map((job) => (
          <li key={job.id}>
            <button type="button" className="link" aria-current={place.tab === 'job' && place.of === job.id} onClick={() => onGo({ tab: 'job', of: job.id })}>{job.text}</button>
            <JobWord texts={texts} job={job} />
          </li>
        ))}
      </ul>
    </nav>
  );
}

/** Ctrl-C ends a command with these. */
const STOPPED = [130, -2];

/** How a job stands, by sign and word. */
export function JobWord({ texts, job }: { texts: PlanTexts; job: Job }) {
  const [word, sign, kind] = job.status === null ? [texts.runs, '▶', 'begun'] : job.status === 0 ? [texts.done, '✓', 'done']
    : STOPPED.includes(job.status) ? [texts.stopped, '■', 'left'] : [texts.failed, '✕', 'failed'];
  return <span className={`step-state is-${kind}`}><span aria-hidden="true">{sign}</span> {word}</span>;
}

function SaveForm({ texts, first, onSaved }: { texts: PlanTexts; first: string; onSaved: () => void }) {
  const { perform, canChange } = useEditor();
  const [typed, setTyped] = useState(first);
  const [isReplaced, setReplaced] = useState(false);
  const save = (event: SyntheticEvent) => {
    event.preventDefault();
    void perform([{ do: 'save', file: typed, replace: isReplaced }], texts.saveLabel(typed)).then((isDone) => isDone && onSaved());
  };
  return (
    <form onSubmit={save}>
      <label>{texts.saveAs} <input type="text" value={typed} onChange={(event) => setTyped(event.target.value)} /></label>
      <label className="check"><input type="checkbox" checked={isReplaced} onChange={(event) => setReplaced(event.target.checked)} />{texts.replaceFile}</label>
      <button type="submit" disabled={!typed || !canChange}>{texts.save}</button>
    </form>
  );
}
