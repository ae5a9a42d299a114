import { useEffect, useState, type SyntheticEvent } from 'react';

import type { Deviation, Files } from '../model/types';
import { Modal } from '../parts/Modal';
import { sentence } from '../server/api';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** Saves the system as a profile, and compares a profile with what lives, in folders that the user has granted. */
export function FilesDialog() {
  const texts = useTexts();
  const words = texts.files;
  const { api, open, perform, canChange, reveal } = useEditor();
  const [known, setKnown] = useState<Files | null>(null);
  const [problem, setProblem] = useState('');
  const [typed, setTyped] = useState('');
  const [isReplaced, setReplaced] = useState(false);
  const [compared, setCompared] = useState<{ file: string; deviations: Deviation[] } | null>(null);
  const close = () => open(null);
  useEffect(() => {
    let isWanted = true;
    api.files().then(
      (files) => {
        if (!isWanted) return;
        setKnown(files);
        setTyped(files.folders[0] ? `${files.folders[0]}/system.yaml` : '');
      },
      (error: unknown) => isWanted && setProblem(sentence(error)),
    );
    return () => {
      isWanted = false;
    };
  }, [api]);
  const save = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!typed || !canChange) return;
    close();
    void perform([{ do: 'save', file: typed, replace: isReplaced }], texts.label.save(typed));
  };
  const compare = (file: string) => {
    setProblem('');
    api.compare(file).then((deviations) => setCompared({ file, deviations }), (error: unknown) => setProblem(sentence(error)));
  };
  const show = (deviation: Deviation) => {
    close();
    reveal(deviation.path.split(' ')[0] ?? deviation.path);
  };
  return (
    <Modal title={words.title} className="connect files" onClose={close}>
      {known?.folders.length === 0 && <p className="empty">{words.noFolder}</p>}
      {problem && <p className="error">{problem}</p>}
      {known !== null && known.folders.length > 0 && (
        <form method="dialog" onSubmit={save}>
          <label>{words.name} <input type="text" value={typed} onChange={(event) => setTyped(event.target.value)} /></label>
          <label className="check"><input type="checkbox" checked={isReplaced} onChange={(event) => setReplaced(event.target.checked)} />{words.replace}</label>
          <button type="submit" className="primary" disabled={!typed || !canChange}>{words.save}</button>
        </form>
      )}
      <ul className="links">
        {known?.files.map((file) => <li key={file}><button type="button" onClick={() => compare(file)}>{words.compare}</button><code>{file}</code></li>)}
      </ul>
      {compared && (
        <section aria-live="polite">
          <h3>{words.result(compared.file, compared.deviations.length)}</h3>
          <ul className="links">{compared.deviations.map((one) => <li key={one.text}><button type="button" className="link" onClick={() => show(one)}>{one.text}</button></li>)}</ul>
        </section>
      )}
      <footer><button type="button" onClick={close}>{texts.keys.close}</button></footer>
    </Modal>
  );
}
