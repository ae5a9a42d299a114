import { useState } from 'react';

import { EXPORT_FORMS, type ExportForm } from '../model/types';
import { Modal } from '../parts/Modal';
import { download } from '../parts/download';
import { clock } from '../parts/numbers';
import { pngOf } from '../parts/raster';
import { sentence } from '../server/api';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** The forms of the exporter, and the one that the browser paints. */
const FORMS = ['png', ...EXPORT_FORMS] as const;
const ENDINGS: Record<ExportForm | 'png', string> = { png: 'png', svg: 'svg', dot: 'dot', mermaid: 'mmd', text: 'txt' };

/** Saves the picture of the whole system as it is, or was at a moment, by the exporter of `rtcryo` and `rtstodot`; or prints the page. */
export function ExportDialog({ host, at }: { host: string; at: number | null }) {
  const texts = useTexts();
  const { api, open } = useEditor();
  const [problem, setProblem] = useState('');
  const close = () => open(null);
  const save = async (form: ExportForm | 'png') => {
    try {
      const content = form === 'png' ? await pngOf(await api.exported('svg', at)) : await api.exported(form, at);
      const moment = at === null ? '' : `-${new Date(at * 1000).toISOString().slice(0, 19).replaceAll(':', '')}Z`;
      download(content, `${host}${moment}.${ENDINGS[form]}`);
      close();
    } catch (error) {
      setProblem(sentence(error));
    }
  };
  const print = () => {
    close();
    // The dialog is not to be on the paper.
    setTimeout(() => window.print());
  };
  return (
    <Modal title={texts.exporting.title} className="export" onClose={close}>
      {at !== null && <p>{texts.exporting.asOf(clock(at, true))}</p>}
      <ul>
        {FORMS.map((form) => <li key={form}><button type="button" onClick={() => void save(form)}>{texts.exporting.forms[form]}</button><span className="note">{texts.exporting.hints[form]}</span></li>)}
        <li><button type="button" onClick={print}>{texts.exporting.print}</button><span className="note">{texts.exporting.printHint}</span></li>
      </ul>
      {problem && <p className="error">{problem}</p>}
      <footer><button type="button" onClick={close}>{texts.plan.cancel}</button></footer>
    </Modal>
  );
}
