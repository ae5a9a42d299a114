import { useId } from 'react';

import { Icon } from '../../parts/icons';
import { ActionList } from './ActionList';
import { VariableTable } from './VariableTable';
import {
  blankTransition, inside, isIn, nameFault, nameOf, outerOf, renamed, replaced, shifted, stateOf, wayId, wayOf, wayText, withInitial, withState, withTransitions,
} from './draft';
import { ChoiceField, NameField, Section, TextField } from './fields';
import type { MachineRecord, Problem, StateRecord, TransitionRecord } from './types';
import type { Change } from './useDraft';
import { useMachineTexts } from './useMachine';

export interface InspectorProps {
  machine: MachineRecord; selected: string; problems: readonly Problem[]; canEdit: boolean;
  change: (change: Change, key?: string) => void; onSelect: (id: string) => void;
  /** Present values of variables, and how one is set; null where none lives. */
  variables: Readonly<Record<string, string>> | null; onVariable: ((name: string, value: string) => void) | null;
}

/** What is selected, to be edited: a state, a transition, else the machine. */
export function Inspector(props: InspectorProps) {
  const texts = useMachineTexts();
  const { machine, selected } = props;
  const way = wayOf(selected);
  const state = stateOf(machine, way?.path ?? selected);
  const transition = way && state?.transitions[way.index];
  const title = state ? (transition ? texts.wayOf(state.path) : texts.stateOf(state.path)) : texts.machine;
  return (
    <aside className="machine-inspector" aria-label={texts.inspector} tabIndex={-1}>
      <h2>{title}</h2>
      {state && way && transition ? <WayForm key={selected} {...props} state={state} way={transition} index={way.index} />
        : state ? <StateForm key={state.path} {...props} state={state} /> : <MachineForm {...props} />}
    </aside>
  );
}

function StateForm({ machine, state, problems, canEdit, change, onSelect }: InspectorProps & { state: StateRecord }) {
  const texts = useMachineTexts();
  const { fields } = texts;
  const { path } = state;
  const own = problems.filter((one) => one.state === path);
  const set = (part: Partial<StateRecord>, key: string) => change((now) => withState(now, path, part), `${path}.${key}`);
  const outers = machine.states.filter((one) => !one.is_final && !isIn(one.path, path)).map((one) => [one.path, one.path] as const);
  const children = inside(machine, path);
  const variables = machine.variables.map((one) => one.name);
  const listOf = (word: 'entry' | 'exit' | 'do') => (
    <ActionList title={fields[word]} actions={state[word]} canEdit={canEdit} isRepeated={word === 'do'} variables={variables} problems={numbered(own, word)}
      onChange={(actions, key) => set({ [word]: actions }, key && `${word}.${key}`)} />
  );
  return (
    <>
      {own.filter((one) => !/^(entry|exit|do|transitions)\./.test(one.part)).map((one) => <p key={one.text} className={one.is_odd ? 'warning' : 'error'}>{one.text}</p>)}
      <NameField key={path} label={fields.name} name={nameOf(path)} isDisabled={!canEdit}
        fault={(name) => { const fault = nameFault(machine, path, name); return fault ? texts.nameFaults[fault] : ''; }}
        onName={(name) => { change((now) => renamed(now, path, name)); onSelect(outerOf(path) ? `${outerOf(path)}.${name}` : name); }} />
      <ChoiceField label={fields.outer} value={outerOf(path)} isDisabled={!canEdit} choices={[['', fields.outermost], ...outers]}
        onChange={(outer) => {
          const made = replaced(machine, path, outer);
          if (!made) return;
          change(() => made[0]);
          onSelect(made[1]);
        }} />
      <label className="check"><input type="checkbox" disabled={!canEdit || isInitialOf(machine, path)} checked={isInitialOf(machine, path)} onChange={() => change((now) => withInitial(now, outerOf(path), path))} />{fields.isInitial}</label>
      {!children.length && <label className="check"><input type="checkbox" disabled={!canEdit} checked={state.is_final} onChange={(event) => set({ is_final: event.target.checked }, '')} />{fields.isFinal}</label>}
      {children.length > 0 && <ChoiceField label={fields.initial} value={state.initial} isDisabled={!canEdit} choices={children.map((one) => [one.path, nameOf(one.path)] as const)} onChange={(initial) => set({ initial }, '')} />}
      {!state.is_final && (
        <>
          <Section title={fields.transitions} action={canEdit && <button type="button" className="quiet" aria-label={`${fields.transitions}: ${texts.addWay}`} onClick={() => {
            change((now) => withTransitions(now, path, (ways) => [...ways, blankTransition('')]));
            onSelect(wayId(path, state.transitions.length));
          }}><Icon name="plus" />{texts.addWay}</button>}>
            <ol className="ways">
              {state.transitions.map((way, index) => <WayRow key={index} state={state} way={way} index={index} canEdit={canEdit} change={change} onSelect={onSelect} />)}
            </ol>
          </Section>
          {listOf('entry')}
          {listOf('do')}
          {listOf('exit')}
        </>
      )}
      <TextField label={fields.doc} value={state.doc} isDisabled={!canEdit} onChange={(doc) => set({ doc }, 'doc')} />
    </>
  );
}

interface RowProps { state: StateRecord; way: TransitionRecord; index: number; canEdit: boolean; change: InspectorProps['change']; onSelect: (id: string) => void }

function WayRow({ state, way, index, canEdit, change, onSelect }: RowProps) {
  const texts = useMachineTexts();
  const what = `${wayText(way) || texts.atOnce} → ${way.to ? nameOf(way.to) : '↺'}`;
  const move = (by: -1 | 1) => change((now) => withTransitions(now, state.path, (ways) => shifted(ways, index, by)));
  return (
    <li>
      <button type="button" className="link" onClick={() => onSelect(wayId(state.path, index))}>{what}</button>
      {canEdit && (
        <span className="buttons">
          <button type="button" className="quiet" disabled={index === 0} aria-label={texts.upOf(what)} title={texts.upOf(what)} onClick={() => move(-1)}><Icon name="up" /></button>
          <button type="button" className="quiet" disabled={index === state.transitions.length - 1} aria-label={texts.downOf(what)} title={texts.downOf(what)} onClick={() => move(1)}><Icon name="down" /></button>
          <button type="button" className="quiet" aria-label={texts.removeOf(what)} title={texts.removeOf(what)} onClick={() => change((now) => withTransitions(now, state.path, (ways) => ways.filter((_, place) => place !== index)))}><Icon name="close" /></button>
        </span>
      )}
    </li>
  );
}

function WayForm({ machine, state, way, index, problems, canEdit, change, onSelect }: InspectorProps & { state: StateRecord; way: TransitionRecord; index: number }) {
  const texts = useMachineTexts();
  const { fields } = texts;
  const id = useId();
  const set = (part: Partial<TransitionRecord>, key: string) =>
    change((now) => withTransitions(now, state.path, (ways) => ways.map((one, place) => (place === index ? { ...one, ...part } : one))), key && `${wayId(state.path, index)}.${key}`);
  const own = problems.filter((one) => one.state === state.path && one.part === `transitions.${index}`);
  return (
    <>
      <button type="button" className="link" onClick={() => onSelect(state.path)}>← {texts.stateOf(state.path)}</button>
      {own.map((one) => <p key={one.text} className={one.is_odd ? 'warning' : 'error'}>{one.text}</p>)}
      <TextField label={fields.on} value={way.on} isDisabled={!canEdit} placeholder={fields.onHint} list={`${id}-events`} onChange={(on) => set({ on }, 'on')} />
      <datalist id={`${id}-events`}>{eventsOf(machine).map((one) => <option key={one} value={one} />)}</datalist>
      <TextField label={fields.when} value={way.when} isDisabled={!canEdit} placeholder={fields.whenHint} onChange={(when) => set({ when }, 'when')} />
      <TextField label={fields.after} value={way.after} isDisabled={!canEdit} onChange={(after) => set({ after }, 'after')} />
      <ChoiceField label={fields.to} value={way.to} isDisabled={!canEdit} choices={[['', fields.stays], ...machine.states.map((one) => [one.path, one.path] as const)]} onChange={(to) => set({ to }, '')} />
      <ActionList title={fields.actions} actions={way.actions} canEdit={canEdit} variables={machine.variables.map((one) => one.name)} onChange={(actions, key) => set({ actions }, key && `actions.${key}`)} />
    </>
  );
}

function MachineForm({ machine, problems, canEdit, change, variables, onVariable }: InspectorProps) {
  const texts = useMachineTexts();
  const { fields } = texts;
  return (
    <>
      <p className="note">{texts.nothing}</p>
      {problems.filter((one) => !one.state).map((one) => <p key={one.text} className={one.is_odd ? 'warning' : 'error'}>{one.text}</p>)}
      <TextField label={fields.name} value={machine.name} isDisabled={!canEdit} onChange={(name) => change((now) => ({ ...now, name }), 'machine.name')} />
      <TextField label={fields.doc} value={machine.doc} isDisabled={!canEdit} onChange={(doc) => change((now) => ({ ...now, doc }), 'machine.doc')} />
      {machine.states.length > 0 && <ChoiceField label={fields.initial} value={machine.initial} isDisabled={!canEdit} choices={inside(machine, '').map((one) => [one.path, one.path] as const)} onChange={(initial) => change((now) => ({ ...now, initial }))} />}
      <VariableTable list={machine.variables} values={variables} canEdit={canEdit} onChange={(list, key) => change((now) => ({ ...now, variables: list }), key)} onSet={onVariable} />
      <p className="note">{texts.keys}</p>
    </>
  );
}

const isInitialOf = (machine: MachineRecord, path: string): boolean => (outerOf(path) ? stateOf(machine, outerOf(path))?.initial : machine.initial) === path;

export const eventsOf = (machine: MachineRecord): string[] =>
  [...new Set(machine.states.flatMap((one) => one.transitions.map((way) => way.on)))].filter((one) => one && one !== '*' && !/^(done|failed)(\.|$)/.test(one)).sort();

function numbered(problems: readonly Problem[], word: string): Map<number, string> {
  return new Map(problems.filter((one) => one.part.startsWith(`${word}.`)).map((one) => [Number(one.part.slice(word.length + 1)), one.text]));
}
