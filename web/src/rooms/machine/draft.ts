import type { MachineRecord, StateRecord, TransitionRecord } from './types';

export const ROW = 20;

/** Changes of a machine: each returns another one, and what it leaves out stays the same object. */

export const nameOf = (path: string): string => path.slice(path.lastIndexOf('.') + 1);
export const outerOf = (path: string): string => path.slice(0, Math.max(0, path.lastIndexOf('.')));
export const isIn = (path: string, outer: string): boolean => outer === '' || path === outer || path.startsWith(`${outer}.`);
const joined = (outer: string, name: string): string => (outer ? `${outer}.${name}` : name);

export const stateOf = (machine: MachineRecord, path: string): StateRecord | undefined => machine.states.find((one) => one.path === path);
export const inside = (machine: MachineRecord, outer: string): StateRecord[] => machine.states.filter((one) => outerOf(one.path) === outer);
export const initialOf = (machine: MachineRecord, outer: string): string => (outer ? stateOf(machine, outer)?.initial : machine.initial) ?? '';
export const isActive = (path: string, active: string): boolean => active !== '' && isIn(active, path);

const NAME = /^[A-Za-z_][\w-]*$/;
/** Behind a dot these ask about a property. */
const RESERVED = ['properties', 'parameters', 'gui', 'listen', 'meta', 'history'];

/** Why a state cannot have a name; null when it can. */
export function nameFault(machine: MachineRecord, path: string, name: string): 'bad' | 'taken' | null {
  if (!NAME.test(name) || RESERVED.includes(name)) return 'bad';
  const wanted = joined(outerOf(path), name);
  return wanted !== path && stateOf(machine, wanted) ? 'taken' : null;
}

export const blankMachine = (): MachineRecord => ({ name: 'machine', doc: '', initial: '', variables: [], states: [] });

const blankState = (path: string): StateRecord => ({ path, initial: '', is_final: false, doc: '', entry: [], exit: [], do: [], transitions: [] });
export const blankTransition = (to: string): TransitionRecord => ({ to, on: '', when: '', after: '', actions: [] });

const withStates = (machine: MachineRecord, states: readonly StateRecord[]): MachineRecord => ({ ...machine, states });

export const withState = (machine: MachineRecord, path: string, part: Partial<StateRecord>): MachineRecord =>
  withStates(machine, machine.states.map((one) => (one.path === path ? { ...one, ...part } : one)));

export function withInitial(machine: MachineRecord, outer: string, initial: string): MachineRecord {
  return outer ? withState(machine, outer, { initial }) : { ...machine, initial };
}

/** A state more inside another one, under a free name; the first one there is the initial one. */
export function added(machine: MachineRecord, outer: string, wish = 'state', part: Partial<StateRecord> = {}): [MachineRecord, string] {
  let count = 1;
  while (stateOf(machine, joined(outer, `${wish}${count}`))) count += 1;
  const path = joined(outer, `${wish}${count}`);
  const last = machine.states.findLastIndex((one) => isIn(one.path, outer));
  const states = [...machine.states.slice(0, last + 1), { ...blankState(path), ...part, path }, ...machine.states.slice(last + 1)];
  const made = withStates(machine, states);
  return [initialOf(made, outer) ? made : withInitial(made, outer, path), path];
}

/** The machine without a state, all inside it, and the transitions that led there. */
export function removed(machine: MachineRecord, path: string): MachineRecord {
  const left = machine.states.filter((one) => !isIn(one.path, path)).map((one) => {
    const transitions = one.transitions.filter((way) => !way.to || !isIn(way.to, path));
    return transitions.length === one.transitions.length ? one : { ...one, transitions };
  });
  const outer = outerOf(path);
  const made = withStates(machine, left);
  return initialOf(made, outer) === path ? withInitial(made, outer, inside(made, outer)[0]?.path ?? '') : made;
}

/** The machine with a state under another path, and all that names it. */
export function moved(machine: MachineRecord, path: string, to: string): MachineRecord {
  if (path === to) return machine;
  const turned = (one: string) => (one && isIn(one, path) ? to + one.slice(path.length) : one);
  const event = (name: string) => (name.startsWith('done.') ? `done.${turned(name.slice(5))}` : name);
  const actions = (list: StateRecord['entry']) =>
    list.map((one) => (one.kind === 'raise' && event(one.target) !== one.target ? { ...one, target: event(one.target) } : one));
  const states = machine.states.map((one) => ({
    ...one, path: turned(one.path), initial: turned(one.initial), entry: actions(one.entry), exit: actions(one.exit), do: actions(one.do),
    transitions: one.transitions.map((way) => ({ ...way, to: turned(way.to), on: event(way.on), actions: actions(way.actions) })),
  }));
  return { ...machine, initial: turned(machine.initial), states: states };
}

export const renamed = (machine: MachineRecord, path: string, name: string): MachineRecord => moved(machine, path, joined(outerOf(path), name));

/** The machine with a state inside another one; null where that has one of its name, or is inside it. */
export function replaced(machine: MachineRecord, path: string, outer: string): [MachineRecord, string] | null {
  const to = joined(outer, nameOf(path));
  if (outer === outerOf(path) || isIn(outer, path) || stateOf(machine, to)) return null;
  const from = outerOf(path);
  const wasInitial = initialOf(machine, from) === path;
  const turned = moved(machine, path, to);
  const own = turned.states.filter((one) => isIn(one.path, to));
  const rest = turned.states.filter((one) => !isIn(one.path, to));
  const last = rest.findLastIndex((one) => isIn(one.path, outer));
  let made = withStates(turned, [...rest.slice(0, last + 1), ...own, ...rest.slice(last + 1)]);
  if (wasInitial) made = withInitial(made, from, inside(made, from)[0]?.path ?? '');
  if (!initialOf(made, outer)) made = withInitial(made, outer, to);
  return [made, to];
}

export const withTransitions = (machine: MachineRecord, path: string, change: (ways: readonly TransitionRecord[]) => readonly TransitionRecord[]): MachineRecord =>
  withState(machine, path, { transitions: change(stateOf(machine, path)?.transitions ?? []) });

/** A list with one item elsewhere: the order of transitions counts. */
export function shifted<T>(list: readonly T[], index: number, by: -1 | 1): readonly T[] {
  const [one, other] = [list[index], list[index + by]];
  if (one === undefined || other === undefined) return list;
  return list.map((item, place) => (place === index ? other : place === index + by ? one : item));
}

/** The id of a transition on the page: `STATE#NUMBER`. */
export const wayId = (path: string, index: number): string => `${path}#${index}`;
export function wayOf(id: string): { path: string; index: number } | null {
  const [path, number] = id.split('#');
  return path !== undefined && number !== undefined ? { path, index: Number(number) } : null;
}

/** A transition as the chart labels it. */
export function wayText(way: TransitionRecord): string {
  const parts = [way.on, way.when && `[${way.when}]`, way.after && `after ${way.after} s`, way.actions.length ? `/ ${way.actions.map((one) => one.target).join(', ')}` : ''];
  return parts.filter(Boolean).join(' ');
}
