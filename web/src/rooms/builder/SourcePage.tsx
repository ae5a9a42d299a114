import { useState } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { openText, type Opened } from './calls';
import { Comparison } from './CodeView';
import { useBuilderTexts, useEditing } from './fields';

/** The profile as text: edited by hand, compared with the form, and then taken over. */
export function SourcePage({ xml }: { xml: string }) {
  const texts = useBuilderTexts();
  const { api } = useEditor();
  const { change } = useEditing();
  const [typed, setTyped] = useState<string | null>(null);
  const [read, setRead] = useState<Opened | null>(null);
  const [problem, setProblem] = useState('');
  const back = () => {
    setTyped(null);
    setRead(null);
    setProblem('');
  };
  const look = () => {
    setProblem('');
    setRead(null);
    openText(api, 'RTC.xml', typed ?? xml).then(setRead, (error: unknown) => setProblem(sentence(error)));
  };
  const take = () => {
    if (read) change(read.form);
    back();
  };
  return (
    <div className="source">
      <p className="note">{texts.source.hint}</p>
      <textarea aria-label={texts.source.text} spellCheck={false} rows={22} value={typed ?? xml} aria-invalid={problem !== ''} onChange={(event) => { setTyped(event.target.value); setRead(null); }} />
      {problem && <p className="error" role="alert">{problem}</p>}
      <div className="buttons">
        <button type="button" onClick={look} disabled={typed === null}>{texts.source.look}</button>
        <button type="button" onClick={back} disabled={typed === null}>{texts.source.back}</button>
        <button type="button" className="primary" onClick={take} disabled={!read || read.xml === xml}>{texts.source.take}</button>
      </div>
      {read && read.notes.length > 0 && <ul>{read.notes.map((note) => <li key={note} className="note warning">⚠ {note}</li>)}</ul>}
      {read && (read.xml === xml ? <p role="status">{texts.source.equal}</p> : <Comparison file="RTC.xml" before={xml} after={read.xml} left={texts.source.present} right={texts.source.wished} />)}
    </div>
  );
}
