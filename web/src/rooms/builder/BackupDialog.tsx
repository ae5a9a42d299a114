import { useEffect, useState } from 'react';

import { Modal } from '../../parts/Modal';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { Comparison } from './CodeView';
import { useBuilderTexts } from './fields';
import type { FilePreview } from './calls';

interface Backup { path: string; name: string; file: string; time: string; text: string }

/** Copies of what was replaced in a folder: compared, put back, cleared. */
export function BackupDialog({ folder, files, onClose, onChanged }: { folder: string; files: readonly FilePreview[]; onClose: () => void; onChanged: () => void }) {
  const texts = useBuilderTexts();
  const { api, canChange } = useEditor();
  const [backups, setBackups] = useState<readonly Backup[] | null>(null);
  const [at, setAt] = useState('');
  const [isAsking, setAsking] = useState(false);
  const [problem, setProblem] = useState('');
  const [looks, setLooks] = useState(0);
  useEffect(() => {
    let isWanted = true;
    api.post<{ backups: Backup[] }>('/api/builder/backups', { folder }).then((found) => isWanted && setBackups(found.backups), (error: unknown) => isWanted && setProblem(sentence(error)));
    return () => {
      isWanted = false;
    };
  }, [api, folder, looks]);
  const act = (path: string, body: object) => {
    setAsking(false);
    api.post(path, { folder, ...body }).then(() => {
      setLooks((n) => n + 1);
      onChanged();
    }, (error: unknown) => setProblem(sentence(error)));
  };
  const shown = backups?.find((one) => one.path === at);
  return (
    <Modal title={texts.backups.title} className="generate" onClose={onClose}>
      <p className="note">{texts.backups.hint}</p>
      {problem && <p className="error" role="alert">{problem}</p>}
      {backups?.length === 0 && <p className="empty">{texts.backups.none}</p>}
      <ul className="links">
        {backups?.map((one) => (
          <li key={one.path}>
            <button type="button" className="link" aria-expanded={one.path === at} onClick={() => setAt(one.path === at ? '' : one.path)}><code>{one.name}</code></button>
            <span className="note">{new Date(one.time).toLocaleString()}</span>
            <button type="button" disabled={!canChange} aria-label={`${texts.backups.putBack}: ${one.name}`} onClick={() => act('/api/builder/put_back', { backup: one.path })}>{texts.backups.putBack}</button>
          </li>
        ))}
      </ul>
      {shown && <Comparison file={shown.file} before={files.find((one) => one.name === shown.file)?.before ?? ''} after={shown.text} left={texts.preview.onDisk} right={shown.name} />}
      <footer>
        {isAsking && <span className="warning">{texts.backups.ask}</span>}
        {backups !== null && backups.length > 0 && <button type="button" className={isAsking ? 'danger filled' : 'danger'} disabled={!canChange} onClick={() => (isAsking ? act('/api/builder/clear', {}) : setAsking(true))}>{texts.backups.clear(backups.length)}</button>}
        <button type="button" onClick={onClose}>{texts.backups.close}</button>
      </footer>
    </Modal>
  );
}
