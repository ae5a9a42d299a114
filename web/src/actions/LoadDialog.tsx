import { useId, useState, type SyntheticEvent } from 'react';

import { shortName } from '../model/ports';
import { Modal } from '../parts/Modal';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { useOffers } from './useOffers';

/** Loads a module into a manager: one that the manager has found, or a path that is typed. */
export function LoadDialog({ manager }: { manager: string }) {
  const texts = useTexts();
  const words = texts.load;
  const { open, perform, canChange } = useEditor();
  const offers = useOffers(manager);
  const [path, setPath] = useState('');
  const [init, setInit] = useState('');
  const id = useId();
  const modules = offers !== null && typeof offers !== 'string' ? offers.modules : [];
  const problem = modules.find((one) => one.path === path)?.problem;
  const close = () => open(null);
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!path.trim() || !canChange) return;
    close();
    void perform([{ do: 'load', manager, path: path.trim(), ...(init.trim() ? { init: init.trim() } : {}) }], texts.label.load(path.trim(), shortName(manager)));
  };
  return (
    <Modal title={words.title(shortName(manager))} className="connect" onClose={close}>
      <form method="dialog" onSubmit={submit}>
        <label>{words.path}
          {/* eslint-disable-next-line jsx-a11y/no-autofocus -- The dialog opens for this field. */}
          <input type="text" autoFocus list={`${id}-modules`} value={path} onChange={(event) => setPath(event.target.value)} />
        </label>
        <datalist id={`${id}-modules`}>{modules.map((one) => <option key={one.path} value={one.path} />)}</datalist>
        {offers === null && <p className="empty">{texts.create.asking}</p>}
        {typeof offers === 'string' && <p className="error">{offers}</p>}
        {offers !== null && typeof offers !== 'string' && <p className="empty">{words.found(modules.length)}</p>}
        {problem && <p className="error">{problem}</p>}
        <label>{words.init} <input type="text" value={init} placeholder={words.initHint} onChange={(event) => setInit(event.target.value)} /></label>
        <footer>
          <button type="button" onClick={close}>{texts.plan.cancel}</button>
          <button type="submit" className="primary" disabled={!path.trim() || !canChange}>{words.go}</button>
        </footer>
      </form>
    </Modal>
  );
}
