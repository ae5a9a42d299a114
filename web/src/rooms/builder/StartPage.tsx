import { useEffect, useRef, useState, type ChangeEvent, type SyntheticEvent } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { newForm, offersOf, openFile, openText, type BuilderOffers, type Opened } from './calls';
import { begun, changeDraft, type Draft } from './draft';
import { useBuilderTexts } from './fields';
import { folderOf, type Form } from './form';

const MOST_BYTES = 4 << 20;

interface Props { draft: Draft | null; onOpen: (file: string) => void; onBack: () => void }

/** Where a component begins: by its name, from a profile in the folders, or from a file of the user. */
export function StartPage({ draft, onOpen, onBack }: Props) {
  const texts = useBuilderTexts();
  const { api } = useEditor();
  const [offers, setOffers] = useState<BuilderOffers | null>(null);
  const [name, setName] = useState('');
  const [problem, setProblem] = useState('');
  const [waiting, setWaiting] = useState<{ form: Form; origin: string } | null>(null);
  const upload = useRef<HTMLInputElement>(null);
  const fail = (error: unknown) => setProblem(sentence(error));
  useEffect(() => {
    let isWanted = true;
    offersOf(api).then((found) => isWanted && setOffers(found), (error: unknown) => isWanted && setProblem(sentence(error)));
    return () => {
      isWanted = false;
    };
  }, [api]);
  const put = (form: Form, origin: string) => {
    changeDraft(() => begun(form, origin, folderOf(origin)));
    onOpen(origin);
  };
  const take = (origin: string) => ({ form }: Opened) => {
    if (draft?.isChanged) setWaiting({ form, origin });
    else put(form, origin);
  };
  const begin = (event: SyntheticEvent) => {
    event.preventDefault();
    newForm(api, name.trim()).then(take(''), fail);
  };
  const read = (event: ChangeEvent<HTMLInputElement>) => {
    const [file] = event.target.files ?? [];
    if (!file) return;
    if (file.size > MOST_BYTES) setProblem(texts.start.tooLarge);
    else file.text().then((text) => openText(api, file.name, text)).then(take(''), fail);
  };
  return (
    <main className="room builder-start" aria-labelledby="builder-title">
      <h2 id="builder-title">{texts.title}</h2>
      <p>{texts.start.lead}</p>
      {draft && <p className="row"><button type="button" className="primary" onClick={onBack}>{texts.start.back}</button>{draft.isChanged && <span className="note">{texts.bar.reopen}</span>}</p>}
      <form onSubmit={begin} className="row">
        <label htmlFor="builder-name">{texts.start.name}</label>
        <input id="builder-name" type="text" value={name} spellCheck={false} placeholder="Gain" onChange={(event) => setName(event.target.value)} />
        <button type="submit" className={draft ? '' : 'primary'} disabled={!name.trim()}>{texts.start.go}</button>
      </form>
      {waiting && (
        <p className="row" role="alert"><span className="warning">⚠ {texts.bar.discarded}</span>
          <button type="button" className="danger" onClick={() => put(waiting.form, waiting.origin)}>{texts.bar.discard}</button>
          <button type="button" onClick={onBack}>{texts.start.back}</button></p>
      )}
      {problem && <p className="error" role="alert">{problem}</p>}
      <h3>{texts.start.known}</h3>
      {offers?.folders.length === 0 && <p className="note">{texts.start.noFolder}</p>}
      {offers && offers.folders.length > 0 && offers.files.length === 0 && <p className="empty">{texts.start.none}</p>}
      <ul className="links">{offers?.files.map((file) => <li key={file}><button type="button" className="link" onClick={() => void openFile(api, file).then(take(file), fail)}><code>{file}</code></button></li>)}</ul>
      <button type="button" onClick={() => upload.current?.click()}>{texts.start.upload}</button>
      <input ref={upload} type="file" hidden accept=".xml,.yaml,.yml,.json" aria-label={texts.start.upload} onChange={read} />
    </main>
  );
}
