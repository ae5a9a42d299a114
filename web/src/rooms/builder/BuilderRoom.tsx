import { useCallback, useEffect, useMemo, useState, type KeyboardEvent } from 'react';

import { Icon } from '../../parts/icons';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { RoomProps } from '../../shell/rooms';
import { BackupDialog } from './BackupDialog';
import { download, exportedText, fateOf, offersOf, openFile, profileFile, usePreview, type BuilderOffers, type Choice, type Written } from './calls';
import { begun, changeDraft, edited, presentDraft, redone, undone, useDraft, type Draft } from './draft';
import { EditingContext, useBuilderTexts, type Editing } from './fields';
import { findingsBelow, folderOf, rowsAt, textAt, type Finding, type Form } from './form';
import { GenerateDialog } from './GenerateDialog';
import { ActivityPage, BasicPage, ConfigurationPage, DataPortsPage, DocumentationPage, LanguagePage, MachinePage, ServicePortsPage } from './pages';
import { OutdatedNote } from './OutdatedNote';
import { PreviewPane } from './PreviewPane';
import { SourcePage } from './SourcePage';
import { StartPage } from './StartPage';
import { TryDialog } from './TryDialog';
import './builder.css';

const PAGES = ['basic', 'activity', 'data', 'services', 'parameters', 'machine', 'documentation', 'language', 'source'] as const;
type Page = (typeof PAGES)[number];

const NO_OFFERS: BuilderOffers = { folders: [], files: [], types: [] };

/** Builds a component: forms at the left, the files that they become at the right. */
export default function BuilderRoom({ system, view }: RoomProps) {
  const { api, show } = useEditor();
  const draft = useDraft();
  const [isStarting, setStarting] = useState(false);
  const [problem, setProblem] = useState('');
  useEffect(() => {
    // A link leads to a file; a draft with changes is not lost by it.
    const present = presentDraft();
    if (!view.of || view.of === present?.origin || present?.isChanged) return;
    openFile(api, view.of).then(
      ({ form }) => changeDraft(() => begun(form, view.of, folderOf(view.of))),
      (error: unknown) => setProblem(sentence(error)),
    );
  }, [api, view.of]);
  const opened = (file: string) => {
    setStarting(false);
    show('builder', file);
  };
  if (!draft || isStarting) return <>{problem && <p className="error" role="alert">{problem}</p>}<StartPage draft={draft} onOpen={opened} onBack={() => setStarting(false)} /></>;
  return <Workshop key={draft.id} draft={draft} system={system} onFiles={() => setStarting(true)} />;
}

function Workshop({ draft, system, onFiles }: { draft: Draft; system: RoomProps['system']; onFiles: () => void }) {
  const texts = useBuilderTexts();
  const { api, canChange, show, reveal } = useEditor();
  const [offers, setOffers] = useState(NO_OFFERS);
  const [page, setPage] = useState<Page>('basic');
  const [file, setFile] = useState('');
  const [dialog, setDialog] = useState<'generate' | 'try' | 'backups' | null>(null);
  const [written, setWritten] = useState<Written | null>(null);
  const [writes, setWrites] = useState(0);
  const [problem, setProblem] = useState('');
  const [waited, setWaited] = useState('');
  useEffect(() => {
    offersOf(api).then(setOffers, (error: unknown) => setProblem(sentence(error)));
  }, [api]);
  const name = textAt(draft.form, 'basicInfo.name');
  const [root] = offers.folders;
  const folder = draft.folder || (root === undefined ? '' : `${root}/${name}`);
  const state = usePreview(api, draft.form, folder, draft.adds, writes + offers.folders.length);
  const { preview } = state;
  const findings = useMemo(() => preview?.findings ?? [], [preview]);
  const change = useCallback((form: Form, about = '') => changeDraft((before) => before && edited(before, form, about)), []);
  const editing = useMemo<Editing>(() => ({ form: draft.form, findings, types: offers.types, change }), [draft.form, findings, offers.types, change]);
  const files = preview?.files ?? [];
  const isCurrent = files.length > 0 && !state.isStale && files.every((one) => ['unchanged', 'kept'].includes(fateOf(one)));
  const own = preview && state.folder === folder ? profileFile(preview.files, name) : undefined;
  const onDisk = own?.before ?? null;
  const isOutdated = onDisk !== null && draft.base !== null && draft.base !== onDisk;
  useEffect(() => {
    // What is there at the first look is what this draft is about.
    if (draft.base === null && onDisk !== null) changeDraft((before) => before && { ...before, base: onDisk });
  }, [draft.base, onDisk]);
  useEffect(() => {
    const look = () => setWrites((count) => count + 1);
    addEventListener('focus', look);
    return () => removeEventListener('focus', look);
  }, []);
  const errors = findings.filter((one) => one.level === 'error').length;

  // The component appears by the stream; then the diagram shows it.
  useEffect(() => {
    if (!waited || !system.components.has(waited)) return;
    reveal(waited);
    show('diagram');
  }, [waited, system.components, reveal, show]);

  const onKey = (event: KeyboardEvent) => {
    const key = event.key.toLowerCase();
    const isSource = event.target instanceof HTMLElement && event.target.closest('.source, dialog') !== null;
    if (!(event.ctrlKey || event.metaKey) || (key !== 'z' && key !== 'y') || isSource) return;
    event.preventDefault();
    event.stopPropagation();
    changeDraft((before) => before && (key === 'y' || event.shiftKey ? redone(before) : undone(before)));
  };
  const save = (kind: string) => exportedText(api, draft.form, kind).then((text) => download(text, `${name}.${kind}`), (error: unknown) => setProblem(sentence(error)));
  const done = (result: Written, choices: Record<string, Choice>) => {
    setDialog(null);
    setWritten(result);
    setWrites((count) => count + 1);
    const choice = own && choices[own.name];
    const base = !own ? null : choice === 'keep' ? own.before : choice === 'merge' ? own.merged : own.after;
    const origin = own?.path ?? `${folder}/RTC.xml`;
    changeDraft((before) => before && { ...before, folder, origin, isChanged: false, base, baseForm: before.form });
    show('builder', origin);
  };

  return (
    <EditingContext value={editing}>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-element-interactions -- Keys of the form inside bubble up to here. */}
      <main className="room builder" aria-labelledby="builder-title" onKeyDown={onKey}>
        <header className="builder-bar">
          <h2 id="builder-title">{name || texts.list.unnamed}{draft.isChanged && <span className="note"> ({texts.bar.changed})</span>}</h2>
          <button type="button" onClick={onFiles}>{texts.bar.files}</button>
          <div className="group">
            <button type="button" className="icon-button" aria-label={texts.bar.undo} title={texts.bar.undo} disabled={!draft.past.length} onClick={() => changeDraft((before) => before && undone(before))}><Icon name="undo" /></button>
            <button type="button" className="icon-button" aria-label={texts.bar.redo} title={texts.bar.redo} disabled={!draft.future.length} onClick={() => changeDraft((before) => before && redone(before))}><Icon name="redo" /></button>
          </div>
          {root !== undefined && <label className="folder">{texts.bar.folder} <input type="text" spellCheck={false} value={folder} onChange={(event) => changeDraft((before) => before && { ...before, folder: event.target.value, base: null })} /></label>}
          {root !== undefined && <label className="check" title={texts.bar.addsHint}><input type="checkbox" checked={draft.adds} onChange={(event) => changeDraft((before) => before && { ...before, adds: event.target.checked, base: null })} />{texts.bar.adds}</label>}
          <span className="verdict" role="status">
            {state.isStale ? '…' : errors ? <span className="error">✕ {texts.bar.errors(errors)}</span> : findings.length ? <span className="warning">⚠ {texts.bar.warnings(findings.length)}</span> : <span className="good">✓ {texts.bar.good}</span>}
          </span>
          <div className="group" role="group" aria-label={texts.bar.export}>
            {['xml', 'yaml', 'json'].map((kind) => <button key={kind} type="button" title={`${texts.bar.export}: ${kind}`} disabled={errors > 0} onClick={() => void save(kind)}>{kind.toUpperCase()}</button>)}
          </div>
          {folder && <button type="button" onClick={() => setDialog('backups')}>{texts.backups.open}</button>}
          <button type="button" disabled={!isCurrent || !canChange || !folder} onClick={() => setDialog('try')}>{texts.bar.tryIt}</button>
          <button type="button" className="primary" disabled={!files.length || state.isStale || !canChange || !folder} onClick={() => setDialog('generate')}>{texts.bar.generate}</button>
        </header>
        <nav className="builder-pages" aria-label={texts.pagesLabel}>
          <ul>{PAGES.map((one) => <li key={one}><button type="button" aria-current={one === page ? 'page' : undefined} onClick={() => setPage(one)}>{texts.pages[one]}<Badge form={draft.form} page={one} findings={findings} /></button></li>)}</ul>
        </nav>
        <section className="builder-form" aria-label={texts.pages[page]}>
          <h3>{texts.pages[page]}</h3>
          {problem && <p className="error" role="alert">{problem}</p>}
          {onDisk !== null && preview && <OutdatedNote draft={draft} onDisk={isOutdated ? onDisk : (draft.base ?? onDisk)} xml={preview.xml} />}
          {findings.filter((one) => one.place === '').map((one) => <p key={one.text} className={one.level === 'error' ? 'error' : 'note warning'}>{one.text}</p>)}
          {page === 'basic' && <BasicPage />}
          {page === 'activity' && <ActivityPage />}
          {page === 'data' && <DataPortsPage />}
          {page === 'services' && <ServicePortsPage />}
          {page === 'parameters' && <ConfigurationPage />}
          {page === 'machine' && <MachinePage />}
          {page === 'documentation' && <DocumentationPage />}
          {page === 'language' && <LanguagePage />}
          {page === 'source' && <SourcePage xml={preview?.xml ?? ''} />}
        </section>
        <div className="builder-result">
          {written && (
            <p className="written" role="status">✓ {texts.generate.done(written.output.split('\n').filter(Boolean).length)} <code>{written.command}</code>
              <button type="button" className="quiet" aria-label={texts.list.remove('')} onClick={() => setWritten(null)}><Icon name="close" /></button></p>
          )}
          {waited && !system.components.has(waited) && <p role="status">{texts.tryIt.waiting(waited)}</p>}
          <PreviewPane state={state} file={file} onFile={setFile} />
        </div>
        {dialog === 'generate' && <GenerateDialog form={draft.form} folder={folder} adds={draft.adds} profile={own?.name ?? 'RTC.xml'} isOutdated={isOutdated} files={files} onClose={() => setDialog(null)} onWritten={done} />}
        {dialog === 'backups' && <BackupDialog folder={folder} files={files} onClose={() => setDialog(null)} onChanged={() => setWrites((count) => count + 1)} />}
        {dialog === 'try' && preview?.module && <TryDialog system={system} module={preview.module} isCurrent={isCurrent} onClose={() => setDialog(null)} onMade={setWaited} />}
      </main>
    </EditingContext>
  );
}

/** Which parts of the profile a page is about. */
const PLACES: Record<Page, readonly string[]> = {
  basic: ['basicInfo'], activity: ['actions'], data: ['dataPorts'], services: ['servicePorts'], parameters: ['configurationSet'],
  machine: [], documentation: ['basicInfo.rtcDoc::doc'], language: ['language'], source: [],
};

/** How many parts a page has, and the worst that is found there. */
function Badge({ form, page, findings }: { form: Form; page: Page; findings: readonly Finding[] }) {
  const texts = useBuilderTexts();
  const count = page === 'data' ? rowsAt(form, 'dataPorts').filter((one) => one.portType !== 'EventPort').length
    : page === 'services' ? rowsAt(form, 'servicePorts').length
      : page === 'parameters' ? rowsAt(form, 'configurationSet.configuration').length : 0;
  const found = findingsBelow(findings, ...PLACES[page]);
  const errors = found.filter((one) => one.level === 'error').length;
  const said = errors ? `✕ ${texts.bar.errors(errors)}` : found.length ? `⚠ ${texts.bar.warnings(found.length)}` : '';
  return <>{count > 0 && <span className="count">{count}</span>}{said && <span className={errors ? 'error' : 'warning'} title={said}>{said.slice(0, 1)}<span className="unseen">{said}</span></span>}</>;
}
