import { useEffect, useState, type SyntheticEvent } from 'react';

import { Modal } from '../../parts/Modal';
import { ServerError, sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { Picture } from './types';
import { useDocumentTexts } from './useDocument';

/** Saves a document under a name; a file that is there is replaced when that is said. */
export function SaveDialog({ picture, save, onClose }: { picture: Picture; save: (file: string, replace: boolean) => Promise<Picture>; onClose: () => void }) {
  const texts = useDocumentTexts();
  const { api, show } = useEditor();
  const [file, setFile] = useState(picture.file);
  const [problem, setProblem] = useState('');
  const [isThere, setThere] = useState(false);
  useEffect(() => {
    if (picture.file) return undefined;
    let isWanted = true;
    api.files().then(
      ({ folders: [folder] }) => isWanted && (folder ? setFile(`${folder}/${picture.name}.xml`) : setProblem(texts.noFolder)),
      (error: unknown) => isWanted && setProblem(sentence(error)),
    );
    return () => {
      isWanted = false;
    };
  }, [api, picture.file, picture.name, texts]);
  const go = async (event: SyntheticEvent) => {
    event.preventDefault();
    try {
      const after = await save(file, isThere);
      onClose();
      show('document', after.file);
    } catch (error) {
      setProblem(sentence(error));
      setThere(error instanceof ServerError && error.kind === 'refused');
    }
  };
  return (
    <Modal title={texts.saveTitle} className="connect" onClose={onClose}>
      <form onSubmit={(event) => void go(event)}>
        <label>{texts.path} <input type="text" value={file} onChange={(event) => { setFile(event.target.value); setThere(false); setProblem(''); }} /></label>
        {problem && <p className="error" role="alert">{problem}</p>}
        <footer>
          <button type="button" onClick={onClose}>{texts.cancel}</button>
          <button type="submit" className={isThere ? 'danger filled' : 'primary'} disabled={!file}>{isThere ? texts.replaceAsk : texts.save}</button>
        </footer>
      </form>
    </Modal>
  );
}
