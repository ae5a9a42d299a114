import { useEffect, useState } from 'react';

import type { Job } from '../../model/types';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useValuesTexts } from './useValuesTexts';

/** A command that is stopped ends as by Ctrl-C. One that had begun has said more than that. */
const STOPPED = [0, -2, 130];
const hasRecorded = ({ status, error }: Job): boolean => STOPPED.includes(status ?? 0) && error !== 'interrupted';

/** Records a port into a folder that was granted, by `rtlog`, until it is stopped. The recording goes on when the page is left. */
export function Recorder({ port }: { port: string }) {
  const texts = useValuesTexts();
  const { api, canWrite, subscriptions } = useEditor();
  const [job, setJob] = useState<Job | null>(null);
  const [folders, setFolders] = useState<string[] | null>(null);
  const [problem, setProblem] = useState('');
  useEffect(() => subscriptions.listen('job', (data) => {
    const news = data as Job;
    setJob((known) => (known?.id === news.id ? { ...known, ...news } : known));
  }), [subscriptions]);
  const attempt = async (work: () => Promise<void>) => {
    setProblem('');
    try {
      await work();
    } catch (error) {
      setProblem(sentence(error));
    }
  };
  const ask = () => attempt(async () => setFolders((await api.files()).folders));
  const start = (file: string, replace: boolean) => attempt(async () => {
    setJob(await api.post<Job>('/api/record', { ports: [port], file, replace }));
    setFolders(null);
  });
  const stop = () => attempt(async () => {
    await api.post(`/api/jobs/${encodeURIComponent(job?.id ?? '')}/stop`, {});
  });
  const isRunning = job?.status === null;
  return (
    <div className="recorder">
      {isRunning ? (
        <p role="status"><span className="dot" aria-hidden="true">●</span> <code>{job.command}</code> <button type="button" onClick={() => void stop()}>{texts.stop}</button></p>
      ) : folders ? <RecordForm port={port} folders={folders} onStart={start} onCancel={() => setFolders(null)} /> : (
        <button type="button" disabled={!canWrite} onClick={() => void ask()}>{texts.record}</button>
      )}
      {job && !isRunning && <p role="status">{!hasRecorded(job) ? texts.recordFailed(job.error) : texts.recorded(job.text.slice(job.text.lastIndexOf('/') + 1))}</p>}
      {problem && <p className="bad" role="alert">{problem}</p>}
    </div>
  );
}

interface FormProps { port: string; folders: string[]; onStart: (file: string, replace: boolean) => Promise<void>; onCancel: () => void }

function RecordForm({ port, folders, onStart, onCancel }: FormProps) {
  const texts = useValuesTexts();
  const [folder, setFolder] = useState(folders[0] ?? '');
  const [name, setName] = useState(() => `${port.slice(port.lastIndexOf('/') + 1).replace(/\.rtc:/, '_').replace(/[^\w.-]/g, '_')}.mcap`);
  const [replace, setReplace] = useState(false);
  if (!folders.length) return <p>{texts.noFolder} <button type="button" onClick={onCancel}>{texts.cancel}</button></p>;
  return (
    <form className="grid" aria-label={texts.recordTitle(port)} onSubmit={(event) => { event.preventDefault(); void onStart(`${folder}/${name}`, replace); }}>
      <label>{texts.folder}<select value={folder} onChange={(event) => setFolder(event.target.value)}>{folders.map((one) => <option key={one}>{one}</option>)}</select></label>
      <label>{texts.file}<input type="text" required value={name} onChange={(event) => setName(event.target.value)} /></label>
      <label className="check"><input type="checkbox" checked={replace} onChange={(event) => setReplace(event.target.checked)} />{texts.replace}</label>
      <div className="buttons"><button type="button" onClick={onCancel}>{texts.cancel}</button><button type="submit" className="primary">{texts.start}</button></div>
    </form>
  );
}
