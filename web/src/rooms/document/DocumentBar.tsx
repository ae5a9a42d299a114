import { useEffect, useState } from 'react';

import type { Files } from '../../model/types';
import { Icon } from '../../parts/icons';
import { Modal } from '../../parts/Modal';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { isRoom } from '../../shell/rooms';
import { checkCommand } from './picture';
import type { Picture } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

/** The room that plans what brings the live system to a file. */
const PLAN: string = 'plan';

/** What a document is, whether it is saved, and what is done with all of it. */
export function DocumentBar({ picture, document, onSaveAs }: { picture: Picture; document: OpenDocument; onSaveAs: () => void }) {
  const texts = useDocumentTexts();
  const { api, canChange, show } = useEditor();
  const [isAsking, setAsking] = useState(false);
  const [problem, setProblem] = useState('');
  const { undo, redo } = picture;
  const told = document.isClosed ? texts.gone : document.problem || problem;
  const save = () => {
    if (!picture.file) onSaveAs();
    else document.save(picture.file, false).catch((error: unknown) => setProblem(sentence(error)));
  };
  const close = () => api.post(`/api/documents/${picture.id}/close`, {}).then(() => show('document'), (error: unknown) => setProblem(sentence(error)));
  useSaveKey(() => canChange && save());
  return (
    <header className="document-bar">
      <button type="button" title={texts.back} onClick={() => show('document')}>{texts.all}</button>
      <h2>{picture.name}</h2>
      <span className="note" title={picture.file}>{picture.file ? picture.file.slice(picture.file.lastIndexOf('/') + 1) : texts.unsaved}</span>
      {picture.is_changed && <strong className="changed">● {texts.changed}</strong>}
      {told && <p className="error" role="alert">{told} <button type="button" className="quiet" aria-label={texts.close} onClick={() => { document.clear(); setProblem(''); }}><Icon name="close" /></button></p>}
      <span className="spring" />
      <div className="group">
        <button type="button" className="icon-button" disabled={undo === null || !canChange} aria-label={undo === null ? texts.undo : texts.undoOf(undo)} title={undo === null ? texts.undo : texts.undoOf(undo)} onClick={() => void document.move('undo')}><Icon name="undo" /></button>
        <button type="button" className="icon-button" disabled={redo === null || !canChange} aria-label={redo === null ? texts.redo : texts.redoOf(redo)} title={redo === null ? texts.redo : texts.redoOf(redo)} onClick={() => void document.move('redo')}><Icon name="redo" /></button>
      </div>
      <button type="button" disabled={!canChange || !picture.components.length} onClick={() => void document.edit({ do: 'arrange' })}><Icon name="arrange" />{texts.arrange}</button>
      <button type="button" className={picture.is_changed ? 'primary' : ''} disabled={!canChange || (!picture.is_changed && picture.file !== '')} onClick={save}>{texts.save}</button>
      <button type="button" disabled={!canChange} onClick={onSaveAs}>{texts.saveAs}</button>
      {isRoom(PLAN) && picture.file && <button type="button" title={texts.restoreHint} onClick={() => show(PLAN, `do:${picture.file}`)}>{texts.restore}</button>}
      <CheckButton file={picture.file} />
      <button type="button" onClick={() => (picture.is_changed ? setAsking(true) : void close())}>{texts.close}</button>
      {isAsking && (
        <Modal title={texts.close} onClose={() => setAsking(false)}>
          <p className="warning">{texts.closeAsk(picture.name)}</p>
          <footer>
            <button type="button" onClick={() => setAsking(false)}>{texts.cancel}</button>
            <button type="button" className="danger filled" onClick={() => void close()}>{texts.closeAnyway}</button>
          </footer>
        </Modal>
      )}
    </header>
  );
}

function CheckButton({ file }: { file: string }) {
  const texts = useDocumentTexts();
  const { api } = useEditor();
  const [said, setSaid] = useState('');
  if (!file) return null;
  const copy = async () => {
    try {
      const { folders } = await api.get<Files>('/api/files');
      const command = checkCommand(file, folders);
      await navigator.clipboard.writeText(command);
      setSaid(texts.copied);
    } catch (error) {
      setSaid(sentence(error));
    }
  };
  return <button type="button" title={`rtprofile check ${file}`} onClick={() => void copy()}><Icon name="copy" />{said || texts.check}</button>;
}

function useSaveKey(save: () => void) {
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (!(event.ctrlKey || event.metaKey) || event.key !== 's' || document.querySelector('dialog[open]')) return;
      event.preventDefault();
      save();
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  });
}
