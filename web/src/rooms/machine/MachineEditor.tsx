import { useEffect, useMemo, useRef, useState } from 'react';

import { managersAt } from '../../model/rights';
import type { System } from '../../model/system';
import { RightsNote } from '../../panels/RightsGate';
import { Icon } from '../../parts/icons';
import { useEditor } from '../../shell/contexts';
import { isTyping } from '../../shell/useShortcuts';
import { ApplyDialog } from './ApplyDialog';
import { Chart } from './Chart';
import { CreateMachineDialog } from './CreateMachineDialog';
import { HistoryStrip } from './HistoryStrip';
import { Inspector } from './Inspector';
import { MachineFiles } from './MachineFiles';
import { Outline } from './Outline';
import { RunBar } from './RunBar';
import { WayDialog } from './WayDialog';
import { differences, marks } from './diff';
import { added, blankTransition, outerOf, removed, stateOf, wayId, wayOf, withTransitions } from './draft';
import { lastPassage } from './live';
import type { Problem } from './types';
import { useAnswer } from './useAnswer';
import { forgetDraft, isChanged, useDraft, type Draft, type Drafting } from './useDraft';
import { useMachine, useMachineTexts } from './useMachine';

type Open = { kind: 'apply' | 'create' | 'files' } | { kind: 'way'; from: string };
const NO_PROBLEMS: readonly Problem[] = [];

/** One machine: its chart or outline with the draft in it, its run, what is selected, and what happened. */
export function MachineEditor({ service, system }: { service: string; system: System }) {
  const texts = useMachineTexts();
  const { show } = useEditor();
  const live = useMachine(service);
  const drafting = useDraft(service, live);
  const { draft } = drafting;
  const title = service || texts.newTitle;
  return (
    <main className="room machine" aria-label={title}>
      <header className="machine-head">
        <button type="button" onClick={() => show('machine')}>← {texts.all}</button>
        <h2>{title}</h2>
        {live.why && <span className="warning" role="status">⚠ {texts.gone(live.why)}</span>}
        {live.machine && <LiveBar service={service} live={{ ...live, machine: live.machine }} />}
      </header>
      <RightsNote system={system} ids={managersAt(system, service)} />
      {draft ? <Drawn service={service} system={system} live={live} draft={draft} drafting={drafting} /> : !live.why && <p className="empty">{texts.connecting}</p>}
    </main>
  );
}

function LiveBar({ service, live }: { service: string; live: Parameters<typeof RunBar>[0]['live'] }) {
  const texts = useMachineTexts();
  const { perform, canChange } = useEditor();
  return (
    <RunBar live={live} canChange={canChange && !live.why}
      onRun={(word) => void perform([{ do: 'run_machine', machine: service, word }], texts.label.run(service, word))}
      onEvent={(name) => void perform([{ do: 'send_event', machine: service, name }], texts.label.event(service, name))} />
  );
}

interface DrawnProps { service: string; system: System; live: ReturnType<typeof useMachine>; draft: Draft; drafting: Drafting }

function Drawn({ service, system, live, draft, drafting }: DrawnProps) {
  const texts = useMachineTexts();
  const { show, perform, canChange } = useEditor();
  const { base, history } = draft;
  const machine = history.now;
  const { answered, error } = useAnswer(machine);
  const [picked, setPicked] = useState('');
  const [view, setView] = useState<'chart' | 'outline'>('chart');
  const [open, setOpen] = useState<Open | null>(null);
  const room = useRef<HTMLDivElement>(null);
  const way = wayOf(picked);
  const chosen = stateOf(machine, way?.path ?? picked);
  const selected = chosen && (!way || way.index < chosen.transitions.length) ? picked : '';
  const active = live.standing?.state ?? '';
  // All of a new machine is new: that needs no signs.
  const signs = useMemo(() => marks(service ? base : machine, machine), [service, base, machine]);
  const changed = isChanged(draft);
  const found = useMemo(() => (changed ? differences(base, machine, texts.diff.parts) : []), [base, machine, changed, texts]);
  const problems = answered?.answer.problems ?? NO_PROBLEMS;
  const isStale = changed && live.machine !== null && live.edits !== draft.edits && !draft.isApplied;
  const isSettled = answered?.machine === machine;

  const addState = (outer: string, part = {}) => {
    const [made, path] = added(machine, outer, 'is_final' in part ? 'end' : 'state', part);
    drafting.change(() => made);
    setPicked(path);
    return path;
  };
  const addWay = (from: string, to: string, on = '') => {
    const state = stateOf(machine, from);
    if (!state || state.is_final) return;
    drafting.change((now) => withTransitions(now, from, (ways) => [...ways, { ...blankTransition(to), on }]));
    setPicked(wayId(from, state.transitions.length));
  };
  const remove = (id: string) => {
    const at = wayOf(id);
    if (at) drafting.change((now) => withTransitions(now, at.path, (ways) => ways.filter((_, index) => index !== at.index)));
    else drafting.change((now) => removed(now, id));
    setPicked(at ? at.path : '');
  };
  const focusInspector = () => requestAnimationFrame(() => room.current?.querySelector<HTMLElement>('.machine-inspector input, .machine-inspector select')?.focus());
  useKeys({
    undo: drafting.undo, redo: drafting.redo,
    add: () => addState(chosen ? outerOf(chosen.path) : ''),
    inside: () => chosen && !chosen.is_final && addState(chosen.path),
    way: () => chosen && !chosen.is_final && setOpen({ kind: 'way', from: chosen.path }),
    remove: () => selected && remove(selected),
    clear: () => setPicked(''),
  }, canChange);
  const apply = async (goto: string) => {
    const action = { do: 'edit_machine' as const, machine: service, text: answered?.answer.text ?? '', edits: draft.edits, goto, before: draft.text };
    const isDone = await perform([action], texts.label.edit(service));
    if (isDone) drafting.applied();
    return isDone;
  };
  return (
    <div className="machine-body" ref={room}>
      <div className="machine-tools" role="toolbar" aria-label={texts.edit}>
        <div className="group" role="group" aria-label={texts.views}>
          {(['chart', 'outline'] as const).map((one) => <button key={one} type="button" aria-pressed={view === one} onClick={() => setView(one)}>{texts[one]}</button>)}
        </div>
        <button type="button" disabled={!canChange} onClick={() => addState(chosen ? outerOf(chosen.path) : '')} title={`${texts.addState} (N)`}><Icon name="plus" />{texts.addState}</button>
        <button type="button" disabled={!canChange || !chosen || chosen.is_final} onClick={() => chosen && addState(chosen.path)} title={`${texts.addInside} (Shift+N)`}><Icon name="plus" />{texts.addInside}</button>
        <button type="button" disabled={!canChange} onClick={() => addState(chosen ? outerOf(chosen.path) : '', { is_final: true })}><Icon name="plus" />{texts.addFinal}</button>
        <button type="button" disabled={!canChange || !chosen || chosen.is_final} onClick={() => chosen && setOpen({ kind: 'way', from: chosen.path })} title={`${texts.addWay} (C)`}><Icon name="plus" />{texts.addWay}</button>
        <button type="button" className="danger" disabled={!canChange || !selected} onClick={() => remove(selected)}>{texts.remove}</button>
        <div className="group">
          <button type="button" className="icon-button" aria-label={texts.undo} title={`${texts.undo} (Ctrl+Z)`} disabled={!history.past.length} onClick={drafting.undo}><Icon name="undo" /></button>
          <button type="button" className="icon-button" aria-label={texts.redo} title={`${texts.redo} (Ctrl+Y)`} disabled={!history.future.length} onClick={drafting.redo}><Icon name="redo" /></button>
        </div>
        <span className="spring" />
        <button type="button" onClick={() => setOpen({ kind: 'files' })}>{texts.files}</button>
        {service && <button type="button" disabled={!changed} onClick={drafting.discard}>{texts.discard}</button>}
        {service
          ? <button type="button" className="primary" disabled={!changed || !canChange || !isSettled || isStale} onClick={() => setOpen({ kind: 'apply' })}>{texts.apply}</button>
          : <button type="button" className="primary" disabled={!canChange || !isSettled || !machine.states.length} onClick={() => setOpen({ kind: 'create' })}>{texts.create}</button>}
      </div>
      <Notes {...{ isStale, changed: service ? found.length : 0, error, problems, canChange }} onKeep={drafting.keep} onTake={drafting.discard} onSelect={setPicked} />
      <div className="machine-view">
        {view === 'outline'
          ? <Outline machine={machine} selected={selected} active={active} marks={signs} problems={problems} canEdit={canChange} onSelect={setPicked}
              onInside={addState} onWay={(from) => setOpen({ kind: 'way', from })} onRemove={remove} />
          : answered && machine.states.length > 0
            ? <Chart machine={answered.machine} layout={answered.answer.layout} problems={problems} selected={selected} active={active} last={lastPassage(live.log)?.passage ?? null}
                marks={signs} canEdit={canChange} onSelect={setPicked} onOpen={focusInspector} onWay={addWay} />
            : machine.states.length === 0 && <p className="empty">{texts.empty}</p>}
      </div>
      <Inspector machine={machine} selected={selected} problems={problems} canEdit={canChange} change={drafting.change} onSelect={setPicked}
        variables={live.standing?.variables ?? null}
        onVariable={service && canChange ? (name, value) => void perform([{ do: 'set_variable', machine: service, name, value }], texts.label.variable(service, name)) : null} />
      {service && <HistoryStrip log={live.log} />}
      {open?.kind === 'apply' && (
        <ApplyDialog name={service} found={found} problems={problems} machine={machine} lost={active && !stateOf(machine, active) ? active : ''} hasComments={/^\s*#/m.test(draft.text)}
          onApply={apply} onClose={() => setOpen(null)} />
      )}
      {open?.kind === 'create' && (
        <CreateMachineDialog system={system} name={machine.name} text={answered?.answer.text ?? ''} onClose={() => setOpen(null)}
          onCreated={(made) => { forgetDraft(''); show('machine', made); }} />
      )}
      {open?.kind === 'files' && <MachineFiles selected={chosen?.path ?? ''} machine={machine} service={service} isChanged={changed} onOpen={(made) => drafting.change(() => made)} onClose={() => setOpen(null)} />}
      {open?.kind === 'way' && <WayDialog machine={machine} from={open.from} onClose={() => setOpen(null)} onDraw={(to, on) => { setOpen(null); addWay(open.from, to, on); }} />}
    </div>
  );
}

interface NotesProps {
  isStale: boolean; changed: number; error: string; problems: readonly Problem[]; canChange: boolean;
  onKeep: () => void; onTake: () => void; onSelect: (id: string) => void;
}

/** What stands between the draft and its being in force. */
function Notes({ isStale, changed, error, problems, canChange, onKeep, onTake, onSelect }: NotesProps) {
  const texts = useMachineTexts();
  return (
    <div className="machine-notes">
      {error && <p className="error" role="alert">{error}</p>}
      {isStale && (
        <p className="warning" role="alert">⚠ {texts.stale}
          <button type="button" disabled={!canChange} onClick={onTake}>{texts.takeTheirs}</button>
          <button type="button" disabled={!canChange} onClick={onKeep}>{texts.keep}</button>
        </p>
      )}
      {changed > 0 && !isStale && <p>{texts.changes(changed)}</p>}
      {problems.length > 0 && (
        <ul aria-label={texts.problems}>
          {problems.slice(0, 3).map((one) => (
            <li key={one.state + one.part + one.text} className={one.is_odd ? 'warning' : 'error'}>
              ⚠ <button type="button" className="link" onClick={() => onSelect(one.part.startsWith('transitions.') ? wayId(one.state, Number(one.part.slice(12))) : one.state)}>{texts.problemOf(one.state, one.text)}</button>
            </li>
          ))}
          {problems.length > 3 && <li className="note">+ {problems.length - 3}</li>}
        </ul>
      )}
    </div>
  );
}

type Keys = Record<'undo' | 'redo' | 'add' | 'inside' | 'way' | 'remove' | 'clear', () => unknown>;

/** Keys of this room, but not while one types. */
function useKeys(keys: Keys, canChange: boolean): void {
  const latest = useRef(keys);
  useEffect(() => {
    latest.current = keys;
  });
  useEffect(() => {
    if (!canChange) return undefined;
    const onKey = (event: KeyboardEvent) => {
      if (isTyping(event) || document.querySelector('dialog[open]')) return;
      const name = keyOf(event);
      if (!name) return;
      event.preventDefault();
      latest.current[name]();
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  }, [canChange]);
}

function keyOf(event: KeyboardEvent): keyof Keys | null {
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) return key === 'z' ? (event.shiftKey ? 'redo' : 'undo') : key === 'y' ? 'redo' : null;
  if (event.altKey) return null;
  if (key === 'n') return event.shiftKey ? 'inside' : 'add';
  return ({ c: 'way', delete: 'remove', backspace: 'remove', escape: 'clear' } as const)[key] ?? null;
}
