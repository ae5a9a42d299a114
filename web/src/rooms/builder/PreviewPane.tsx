import { useState } from 'react';

import { fateOf, type FilePreview, type PreviewState } from './calls';
import { CodeView, Comparison } from './CodeView';
import { compared, counted } from './difference';
import { useBuilderTexts } from './fields';

/** What becomes of a file, as a sign beside its word. */
export const FATE_SIGNS = { written: '●', unchanged: '=', kept: '◐', conflict: '⚠' } as const;

export function Fate({ file }: { file: FilePreview }) {
  const texts = useBuilderTexts();
  const isFresh = file.before === null;
  const fate = fateOf(file);
  return <span className={`fate fate-${fate}`}><span aria-hidden="true">{isFresh ? '+' : FATE_SIGNS[fate]}</span> {isFresh ? texts.preview.fresh : texts.preview.fates[fate]}</span>;
}

/** The files that would be generated, beside those on the disk. */
export function PreviewPane({ state, file, onFile }: { state: PreviewState; file: string; onFile: (name: string) => void }) {
  const texts = useBuilderTexts();
  const [isDifference, setDifference] = useState(false);
  const { preview, files, isStale, error } = state;
  const isOld = preview !== null && preview.files.length === 0;
  const shown = files.find((one) => one.name === file) ?? files[0];
  return (
    <section className={`preview ${isStale || isOld ? 'is-waiting' : ''}`} aria-label={texts.preview.title} aria-busy={isStale}>
      <div className="files-bar" role="group" aria-label={texts.preview.list}>
        {files.map((one) => (
          <button key={one.name} type="button" className="file" aria-pressed={one === shown} title={one.why ?? undefined} onClick={() => onFile(one.name)}>
            <span>{one.name}</span><Fate file={one} />
          </button>
        ))}
        <span className="note" role="status">{isStale ? texts.preview.stale : isOld && files.length > 0 ? texts.preview.old : ''}</span>
      </div>
      {error && <p className="error" role="alert">{error}</p>}
      {!shown && !error && <p className="empty">{isStale ? texts.preview.stale : texts.preview.none}</p>}
      {shown && (
        <>
          <div className="row view-bar">
            <code>{shown.path}</code>
            {shown.before !== null && shown.before !== shown.after && (
              <div className="group" role="group" aria-label={texts.preview.code}>
                <button type="button" aria-pressed={!isDifference} onClick={() => setDifference(false)}>{texts.preview.whole}</button>
                <button type="button" aria-pressed={isDifference} onClick={() => setDifference(true)}>{texts.preview.difference} <Lines file={shown} /></button>
              </div>
            )}
            {shown.why && <span className={fateOf(shown) === 'conflict' ? 'warning' : 'note'}>{shown.why}</span>}
          </div>
          {isDifference && shown.before !== null && shown.before !== shown.after
            ? <Comparison file={shown.name} before={shown.before} after={shown.after} left={texts.preview.onDisk} right={texts.preview.generated} />
            : <CodeView file={shown.name} text={fateOf(shown) === 'kept' ? (shown.before ?? shown.after) : shown.after} before={shown.before} />}
        </>
      )}
      {preview && preview.notes.length > 0 && <ul className="notes" aria-label={texts.preview.notes}>{preview.notes.map((note) => <li key={note} className="note">⚠ {note}</li>)}</ul>}
    </section>
  );
}

function Lines({ file }: { file: FilePreview }) {
  const texts = useBuilderTexts();
  const { added, removed } = counted(compared(file.before ?? '', file.after));
  return <span className="note">{texts.preview.lines(added, removed)}</span>;
}
