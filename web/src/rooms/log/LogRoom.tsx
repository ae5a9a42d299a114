import { useEffect, useMemo, useRef, useState } from 'react';

import { lineOf, nameOf, noFilter, recordsIn, testOf, type LogRecord } from '../../model/logFilter';
import type { System } from '../../model/system';
import type { Job } from '../../model/types';
import { download } from '../../parts/download';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { RoomProps } from '../../shell/rooms';
import { useJobRows } from '../jobs/useJob';
import { FilterEditor } from './FilterEditor';
import { useLogTexts } from './useLogTexts';
import './log.css';

const LEVELS = ['FATAL', 'ERROR', 'WARN', 'INFO', 'NORMAL', 'DEBUG', 'TRACE', 'VERBOSE', 'PARANOID'] as const;
/** More rows than these nobody reads; all that match are saved. */
const SHOWN = 500;
/** A command that is stopped ends as by Ctrl-C. */
const STOPPED = [0, -2, 130];

/** What components log: followed by `rtvlog`, filtered here. */
export default function LogRoom({ system, view }: RoomProps) {
  const texts = useLogTexts();
  const { api, show } = useEditor();
  const [level, setLevel] = useState<string>('NORMAL');
  const [started, setStarted] = useState('');
  const [problem, setProblem] = useState('');
  const path = view.of || '/';
  const job = latestOf(system, path, started);
  const isRunning = job?.status === null;
  const attempt = (work: Promise<unknown>) => work.then(() => setProblem(''), (error: unknown) => setProblem(sentence(error)));
  const [opened, setOpened] = useState<{ name: string; records: readonly LogRecord[]; bad: number } | null>(null);
  const upload = useRef<HTMLInputElement>(null);
  const open = (file: File | undefined) => file && attempt(file.text().then((text) => setOpened({ name: file.name, ...recordsIn(text) })));
  const start = () => attempt(api.post<Job>('/api/logs', { path, level }).then(({ id }) => setStarted(id)));
  const stop = () => attempt(api.post(`/api/jobs/${encodeURIComponent(job?.id ?? '')}/stop`, {}));
  return (
    <main className="room log" aria-labelledby="log-title">
      <header className="row">
        <h2 id="log-title">{texts.title}</h2>
        <label>{texts.path} <select value={path} disabled={isRunning} onChange={(event) => show('log', event.target.value)}>
          {pathsOf(system, path).map((one) => <option key={one} value={one}>{one === '/' ? texts.all : one}</option>)}
        </select></label>
        <label>{texts.level} <select value={level} disabled={isRunning} onChange={(event) => setLevel(event.target.value)}>{LEVELS.map((one) => <option key={one}>{one}</option>)}</select></label>
        {isRunning ? <button type="button" onClick={() => void stop()}>{texts.stop}</button> : <button type="button" className="primary" onClick={() => void start()}>{texts.start}</button>}
        <button type="button" onClick={() => upload.current?.click()}>{texts.open}</button>
        <input ref={upload} type="file" hidden accept=".jsonl,.log" aria-label={texts.open} onChange={(event) => {
          void open(event.target.files?.[0]);
          event.target.value = '';
        }} />
        {!opened && job && <code>{job.command}</code>}
      </header>
      {problem && <p className="bad" role="alert">{problem}</p>}
      {opened && <p className="row">{texts.opened(opened.name)}{opened.bad > 0 && ` ${texts.bad(opened.bad)}`} <button type="button" onClick={() => setOpened(null)}>{texts.close}</button></p>}
      {!opened && job && !isRunning && !STOPPED.includes(job.status ?? 0) && <p className="bad" role="alert">{texts.failed(job.error)}</p>}
      {opened ? <Records key={opened.name} first={0} rows={opened.records} error="" system={system} />
        : job ? <Followed key={job.id} job={job} system={system} /> : <p className="empty">{texts.idle}</p>}
    </main>
  );
}

/** The job that was started here, else the last one that follows this path. */
function latestOf(system: System, path: string, started: string): Job | undefined {
  const own = system.jobs.get(started);
  const ofPath = [...system.jobs.values()].filter(({ kind, command }) => kind === 'log' && command.endsWith(` -- ${path}`)).at(-1);
  return own?.command.endsWith(` -- ${path}`) ? own : ofPath;
}

/** What the log can be of: everything, managers, slaves, components. */
function pathsOf(system: System, path: string): string[] {
  const known = ['/', ...system.managers.keys(), ...[...system.processes.keys()].filter((id) => !system.managers.has(id)), ...[...system.components.keys()].sort()];
  return known.includes(path) ? known : [path, ...known];
}

function Followed({ job, system }: { job: Job; system: System }) {
  const { first, rows, error } = useJobRows(job.id);
  return <Records first={first} rows={rows as unknown as readonly LogRecord[]} error={error} system={system} />;
}

interface RecordsProps { first: number; rows: readonly LogRecord[]; error: string; system: System }

/** Records that are filtered here; `first` is the number of the first of them. */
function Records({ first, rows, error, system }: RecordsProps) {
  const texts = useLogTexts();
  const { show, reveal } = useEditor();
  const [filter, setFilter] = useState(noFilter);
  const [cleared, setCleared] = useState(0);
  const [isFollowing, setFollowing] = useState(true);
  const { test, problem } = useMemo(() => testOf(filter), [filter]);
  const records = rows.slice(Math.max(cleared - first, 0));
  const fitting = records.filter(test);
  const shown = fitting.slice(-SHOWN);
  const list = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (isFollowing && list.current) list.current.scrollTop = list.current.scrollHeight;
  }, [isFollowing, rows, filter]);
  const save = (lineOfRecord: (record: LogRecord) => string, ending: string) =>
    download(new Blob([fitting.map((record) => `${lineOfRecord(record)}\n`).join('')], { type: 'text/plain' }), `${system.host}-log.${ending}`);
  const go = (record: LogRecord) => {
    const id = [...system.components.values()].find((one) => one.name === record.component)?.id;
    if (!id) return;
    show('diagram');
    reveal(id);
  };
  return (
    <>
      <FilterEditor filter={filter} problem={problem} onChange={setFilter} />
      <div className="row">
        <p role="status">{texts.of(fitting.length, records.length)}</p>
        <label className="check"><input type="checkbox" checked={isFollowing} onChange={(event) => setFollowing(event.target.checked)} />{texts.follow}</label>
        <button type="button" onClick={() => setCleared(first + rows.length)}>{texts.clear}</button>
        <button type="button" disabled={!fitting.length} onClick={() => save(JSON.stringify, 'jsonl')}>{texts.save}</button>
        <button type="button" disabled={!fitting.length} onClick={() => save(lineOf, 'txt')}>{texts.saveText}</button>
      </div>
      {error && <p className="bad" role="alert">{error}</p>}
      {fitting.length > shown.length && <p>{texts.earlier(fitting.length - shown.length)}</p>}
      {!shown.length ? <p className="empty">{records.length ? texts.noMatch : texts.none}</p> : (
        // A region that scrolls must be reachable by Tab, else it cannot be scrolled by keys.
        // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
        <div className="scroll" tabIndex={0} role="group" aria-labelledby="log-title" ref={list}>
          <table>
            <thead><tr>{Object.entries(texts.columns).map(([key, title]) => <th key={key} scope="col">{title}</th>)}</tr></thead>
            <tbody>
              {shown.map((record, index) => (
                <tr key={`${record.time} ${record.pid} ${fitting.length - shown.length + index}`} data-level={record.level}>
                  <td className="time" title={record.time}>{timeText(record.time)}</td>
                  <td className="level">{record.level}</td>
                  <td>{record.manager}</td>
                  <td>{record.component ? <button type="button" className="link" aria-label={texts.inDiagram(record.component)} onClick={() => go(record)}>{record.component}</button> : nameOf(record)}</td>
                  <td>{record.pid}</td>
                  <td>{record.host}</td>
                  <td className="message">{record.message}{record.exception && <pre>{record.exception}</pre>}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </>
  );
}

/** The time of this place, with thousandths. */
function timeText(time: string): string {
  const date = new Date(time);
  return `${date.toLocaleTimeString([], { hour12: false })}.${String(date.getMilliseconds()).padStart(3, '0')}`;
}
