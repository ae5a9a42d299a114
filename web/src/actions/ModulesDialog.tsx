import { shortName } from '../model/ports';
import { Modal } from '../parts/Modal';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { useOffers } from './useOffers';

/** Modules that a manager has loaded; each can be forgotten. */
export function ModulesDialog({ manager }: { manager: string }) {
  const texts = useTexts();
  const { managers, label } = texts.manage;
  const { open, perform, canChange } = useEditor();
  const offers = useOffers(manager);
  const loaded = offers !== null && typeof offers !== 'string' ? offers.loaded : [];
  const close = () => open(null);
  const forget = ({ path, init }: { path: string; init: string }) => {
    close();
    void perform([{ do: 'unload', manager, path, init }], label.unload(path, shortName(manager)));
  };
  return (
    <Modal title={managers.modules} className="export" onClose={close}>
      {offers === null && <p className="empty">{texts.create.asking}</p>}
      {typeof offers === 'string' && <p className="error">{offers}</p>}
      {offers !== null && typeof offers !== 'string' && loaded.length === 0 && <p className="empty">{managers.noModules}</p>}
      <ul>
        {loaded.map((module) => (
          <li key={module.path}><button type="button" disabled={!canChange} onClick={() => forget(module)}>{managers.forget(module.path)}</button><span className="note">{module.init}</span></li>
        ))}
      </ul>
      <footer><button type="button" onClick={close}>{texts.keys.close}</button></footer>
    </Modal>
  );
}
