import { useState } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { openText, type Opened } from './calls';
import { Comparison } from './CodeView';
import { changeDraft, edited, type Draft } from './draft';
import { useBuilderTexts } from './fields';
import { mergedForms } from './merge';

/** Tells that the profile on the disk was changed by somebody else, and offers to bring it together with the form, or to take it over. */
export function OutdatedNote({ draft, onDisk, xml }: { draft: Draft; onDisk: string; xml: string }) {
  const texts = useBuilderTexts();
  const { api } = useEditor();
  const [isCompared, setCompared] = useState(false);
  const [conflicts, setConflicts] = useState<readonly string[]>([]);
  const [problem, setProblem] = useState('');
  const take = (how: (theirs: Opened, before: Draft) => Draft) => {
    openText(api, 'RTC.xml', onDisk).then(
      (theirs) => changeDraft((before) => before && { ...how(theirs, before), base: onDisk, baseForm: theirs.form }),
      (error: unknown) => setProblem(sentence(error)),
    );
  };
  const merge = () => take((theirs, before) => {
    const merged = mergedForms(before.baseForm, before.form, theirs.form);
    setConflicts(merged.conflicts);
    return edited(before, merged.form, '');
  });
  if (draft.base === onDisk) return conflicts.length ? <p className="warning" role="alert">⚠ {texts.outdated.conflicts} <code>{conflicts.join(', ')}</code></p> : null;
  return (
    <section className="outdated" role="alert" aria-label={texts.outdated.title}>
      <p className="warning">⚠ {texts.outdated.title}</p>
      {problem && <p className="error">{problem}</p>}
      <div className="buttons">
        <button type="button" aria-expanded={isCompared} onClick={() => setCompared(!isCompared)}>{texts.outdated.compare}</button>
        <button type="button" className="primary" onClick={merge}>{texts.outdated.merge}</button>
        <button type="button" onClick={() => take((theirs, before) => edited(before, theirs.form, ''))}>{texts.outdated.take}</button>
        <button type="button" onClick={() => changeDraft((before) => before && { ...before, base: onDisk })}>{texts.outdated.ignore}</button>
      </div>
      {isCompared && <Comparison file="RTC.xml" before={onDisk} after={xml} left={texts.preview.onDisk} right={texts.source.present} />}
    </section>
  );
}
