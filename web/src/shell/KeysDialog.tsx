import { Modal } from '../parts/Modal';
import { useTexts } from '../texts';
import { useEditor } from './contexts';

export function KeysDialog() {
  const texts = useTexts();
  const { open } = useEditor();
  return (
    <Modal title={texts.keys.title} className="keys" onClose={() => open(null)}>
      <dl className="fields">
        {texts.keys.rows.map(([key, text]) => <div key={key}><dt><kbd>{key}</kbd></dt><dd>{text}</dd></div>)}
      </dl>
      <footer><button type="button" className="primary" onClick={() => open(null)}>{texts.keys.close}</button></footer>
    </Modal>
  );
}
