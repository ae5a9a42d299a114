import { useState } from 'react';

import { EXPORT_FORMS, type ExportForm } from '../model/types';
import { download } from '../parts/download';
import { Modal } from '../parts/Modal';
import { download } from '../parts/download';
import { sentence } from '../server/api';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

const ENDINGS: Record<ExportForm, string> = { svg: 'svg', dot: 'dot', mermaid: 'mmd', text: 'txt' };

/** Saves the picture of the whole system, by the exporter of `rtcryo` and `rtstodot`. */
export function ExportDialog({ host }: { host: string }) {
  const texts = useTexts();
  const { api, open } = useEditor();
  const [problem, setProblem] = useState('');
  const close = () => open(null);
  const save = async (form: ExportForm) => {
    try {
      download(await api.exported(form), `${host}.${ENDINGS[form]}`);
      close();
    } catch (error) {
      setProblem(sentence(error));
    }
  };
  return (
    <Modal title={texts.exporting.title} className="export" onClose={close}>
      <ul>
        {EXPORT_FORMS.map((form) => <li key={form}><button type="button" onClick={() => void save(form)}>{texts.exporting.forms[form]}</button><span className="note">{texts.exporting.hints[form]}</span></li>)}
      </ul>
      {problem && <p className="error">{problem}</p>}
      <footer><button type="button" onClick={close}>{texts.plan.cancel}</button></footer>
    </Modal>
  );
}
