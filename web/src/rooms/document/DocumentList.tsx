import { useEffect, useState, type SyntheticEvent } from 'react';

import type { Files } from '../../model/types';
import { Icon } from '../../parts/icons';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { Draft, Heading, Picture } from './types';
import { UNSAVED, useDocumentTexts } from './useDocument';

/** Files of the granted folders and documents that are open; begins a new diagram. */
export function DocumentList() {
  const texts = useDocumentTexts();
  const { api, show, canChange, subscriptions } = useEditor();
  const [known, setKnown] = useState<Files | null>(null);
  const [open, setOpen] = useState<readonly Heading[]>([]);
  const [drafts, setDrafts] = useState<readonly Draft[]>([]);
  const [looks, setLooks] = useState(0);
  const [problem, setProblem] = useState('');
  const [filter, setFilter] = useState('');
  const [name, setName] = useState('');
  useEffect(() => {
    let isWanted = true;
    const look = () => Promise.all([api.files(), api.get<{ documents: Heading[]; drafts: Draft[] }>('/api/documents')]).then(
      ([files, found]) => {
        if (!isWanted) return;
        setKnown(files);
        setOpen(found.documents);
        setDrafts(found.drafts);
      },
      (error: unknown) => isWanted && setProblem(sentence(error)),
    );
    void look();
    const close = subscriptions.listen('document', () => void look());
    return () => {
      isWanted = false;
      close();
    };
  }, [api, subscriptions, looks]);
  const drop = (draft: string) => api.post('/api/documents/drafts/drop', { draft }).then(() => setLooks((n) => n + 1), (error: unknown) => setProblem(sentence(error)));
  const take = (draft: string) => api.post<Picture>('/api/documents/drafts/take', { draft }).then(
    ({ id, file }) => show('document', file || UNSAVED + id), (error: unknown) => setProblem(sentence(error)),
  );
  const begin = (event: SyntheticEvent) => {
    event.preventDefault();
    api.post<Picture>('/api/documents/new', { name }).then(
      ({ id }) => show('document', UNSAVED + id), (error: unknown) => setProblem(sentence(error)),
    );
  };
  const files = (known?.files ?? []).filter((file) => file.toLowerCase().includes(filter.toLowerCase()));
  return (
    <main className="room documents" aria-labelledby="documents-title">
      <header><h2 id="documents-title">{texts.title}</h2><p>{texts.lead}</p></header>
      {problem && <p className="error" role="alert">{problem}</p>}
      <form onSubmit={begin} className="row">
        <label>{texts.newName} <input type="text" value={name} onChange={(event) => setName(event.target.value)} /></label>
        <button type="submit" className="primary" disabled={!canChange || !name.trim()}><Icon name="plus" />{texts.newOne}</button>
      </form>
      {open.length > 0 && (
        <section aria-label={texts.openDocuments}>
          <h3>{texts.openDocuments}</h3>
          <ul className="links">
            {open.map((one) => (
              <li key={one.id}>
                <button type="button" className="link" onClick={() => show('document', one.file || UNSAVED + one.id)}>{one.name}</button>
                <span className="note">{one.file || texts.unsaved}</span>{one.is_changed && <strong className="changed">● {texts.changed}</strong>}
              </li>
            ))}
          </ul>
        </section>
      )}
      {drafts.length > 0 && (
        <section aria-label={texts.drafts}>
          <h3>{texts.drafts}</h3>
          <p className="note">{texts.draftsHint}</p>
          <ul className="links">
            {drafts.map((one) => (
              <li key={one.id}>
                <strong>{one.name}</strong> <span className="note">{one.file || texts.unsaved} · {new Date(one.time).toLocaleString()}</span>
                <button type="button" disabled={!canChange} aria-label={`${texts.takeDraft}: ${one.name}`} onClick={() => void take(one.id)}>{texts.takeDraft}</button>
                <button type="button" className="quiet" disabled={!canChange} aria-label={`${texts.dropDraft}: ${one.name}`} onClick={() => void drop(one.id)}>{texts.dropDraft}</button>
              </li>
            ))}
          </ul>
        </section>
      )}
      <section aria-label={texts.files}>
        <h3>{texts.files}</h3>
        {known?.folders.length === 0 && <p className="empty">{texts.noFolder}</p>}
        {known !== null && known.folders.length > 0 && known.files.length === 0 && <p className="empty">{texts.noFiles}</p>}
        {known !== null && known.files.length > 8 && <input type="search" aria-label={texts.filter} placeholder={texts.filter} value={filter} onChange={(event) => setFilter(event.target.value)} />}
        <ul className="links">
          {files.map((file) => <li key={file}><button type="button" className="link" onClick={() => show('document', file)}>{file.slice(file.lastIndexOf('/') + 1)}</button><span className="note">{file}</span></li>)}
        </ul>
      </section>
    </main>
  );
}
