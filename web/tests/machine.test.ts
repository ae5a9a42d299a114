import { describe, expect, it } from 'vitest';

import { isLastWay } from '../src/rooms/machine/chart';
import { differences, marks } from '../src/rooms/machine/diff';
import { added, blankMachine, blankTransition, moved, nameFault, removed, renamed, replaced, shifted, stateOf, wayId, wayOf, withTransitions } from '../src/rooms/machine/draft';
import { begun, redone, stepped, undone } from '../src/rooms/machine/history';
import { UNKNOWN, lastPassage, told } from '../src/rooms/machine/live';
import type { Entry, MachineRecord, Standing } from '../src/rooms/machine/types';
import { draftFrom, isChanged, newDraft, reduceDraft, type Draft } from '../src/rooms/machine/useDraft';
import { machineTexts } from '../src/texts/en/machine';

const words = machineTexts.diff.parts;

/** a -go-> b, b with b.x and b.y inside, b -back-> a; the end of b.y raises done.b. */
function turnstile(): MachineRecord {
  let [machine] = added(blankMachine(), '', 'a');
  machine = renamed(machine, 'a1', 'a');
  [machine] = added(machine, '', 'b');
  machine = renamed(machine, 'b1', 'b');
  [machine] = added(machine, 'b', 'x');
  [machine] = added(machine, 'b', 'y', { is_final: true });
  machine = withTransitions(machine, 'a', () => [{ ...blankTransition('b'), on: 'go' }]);
  return withTransitions(machine, 'b', () => [{ ...blankTransition('a'), on: 'done.b' }, { ...blankTransition('a'), on: 'back', actions: [{ kind: 'raise', target: 'done.b.x1', how: 'value', value: '', every: '' }] }]);
}

describe('draft', () => {
  it('makes the first state inside another one its initial one, and puts states behind those round them', () => {
    const machine = turnstile();
    expect(machine.initial).toBe('a');
    expect(stateOf(machine, 'b')?.initial).toBe('b.x1');
    expect(machine.states.map((one) => one.path)).toEqual(['a', 'b', 'b.x1', 'b.y1']);
  });
  it('renames a state with all that names it', () => {
    const machine = renamed(turnstile(), 'b', 'open');
    expect(machine.states.map((one) => one.path)).toEqual(['a', 'open', 'open.x1', 'open.y1']);
    expect(stateOf(machine, 'a')?.transitions[0]?.to).toBe('open');
    expect(stateOf(machine, 'open')).toMatchObject({ initial: 'open.x1', transitions: [{ on: 'done.open' }, { actions: [{ target: 'done.open.x1' }] }] });
    expect(moved(machine, 'a', 'a')).toBe(machine);
  });
  it('removes a state with what led there, and names another initial one', () => {
    const machine = removed(turnstile(), 'a');
    expect(machine).toMatchObject({ initial: 'b', states: [{ path: 'b', transitions: [] }, { path: 'b.x1' }, { path: 'b.y1' }] });
    expect(stateOf(removed(turnstile(), 'b.x1'), 'b')?.initial).toBe('b.y1');
    expect(removed(removed(turnstile(), 'a'), 'b')).toMatchObject({ initial: '', states: [] });
  });
  it('puts a state inside another one, and refuses what cannot be', () => {
    const [machine, path] = replaced(turnstile(), 'a', 'b') ?? [];
    expect(path).toBe('b.a');
    expect(machine).toMatchObject({ initial: 'b', states: [{ path: 'b', transitions: [{ to: 'b.a' }, { to: 'b.a' }] }, { path: 'b.x1' }, { path: 'b.y1' }, { path: 'b.a' }] });
    expect(replaced(turnstile(), 'b', 'b.x1')).toBeNull();
    expect(replaced(turnstile(), 'a', '')).toBeNull();
  });
  it('tells why a name cannot be', () => {
    const machine = turnstile();
    expect(['b', '1a', 'a b', 'meta', '', 'a', 'ok-1'].map((name) => nameFault(machine, 'a', name))).toEqual(['taken', 'bad', 'bad', 'bad', 'bad', null, null]);
  });
  it('keeps the order of transitions, and their ids', () => {
    expect(shifted(['a', 'b', 'c'], 2, -1)).toEqual(['a', 'c', 'b']);
    expect(shifted(['a'], 0, 1)).toEqual(['a']);
    expect(wayOf(wayId('b.x', 3))).toEqual({ path: 'b.x', index: 3 });
    expect(wayOf('b.x')).toBeNull();
  });
});

describe('difference', () => {
  it('tells states and transitions that came, went and changed', () => {
    const base = turnstile();
    let draft = removed(base, 'b.y1');
    draft = withTransitions(draft, 'a', (ways) => [...ways, { ...blankTransition(''), on: 'tick' }]);
    [draft] = added(draft, '', 'c');
    expect(differences(base, { ...draft, variables: [{ name: 'n', value: '1' }] }, words)).toEqual([
      { sign: '~', path: '', lines: ['variables: + n = 1'] },
      { sign: '~', path: 'a', lines: ['+ tick → ↺'] },
      { sign: '+', path: 'c1', lines: [] },
      { sign: '−', path: 'b.y1', lines: [] },
    ]);
    expect([...marks(base, draft)]).toEqual([['a', '~'], ['a#1', '+'], ['c1', '+']]);
  });
  it('tells the order of transitions, and nothing where nothing is', () => {
    const base = turnstile();
    const turned = withTransitions(base, 'b', (ways) => shifted(ways, 0, 1));
    expect(differences(base, turned, words)).toEqual([{ sign: '~', path: 'b', lines: ['order'] }]);
    expect(differences(base, structuredClone(base), words)).toEqual([]);
  });
});

describe('history', () => {
  it('takes back a word that was typed, and not each letter', () => {
    const [one, two, three] = [turnstile(), blankMachine(), blankMachine()];
    const typed = stepped(stepped(begun(one), two, 'name'), three, 'name');
    expect(undone(typed)?.now).toBe(one);
    expect(redone(undone(typed) ?? typed)?.now).toBe(three);
    expect(undone(begun(one))).toBeNull();
    expect(stepped(begun(one), one)).toEqual(begun(one));
  });
});

describe('what the server tells', () => {
  const standing: Standing = { state: 'a', run: 'running', status: 'running', edits: 1, source: '', variables: {} };
  const log: Entry[] = [[1, 5, 'event', 'go'], [2, 6, 'transition', 'a -> b.x1: on go']];
  it('is put to what is known; a service that begins anew takes its place', () => {
    let live = told(UNKNOWN, { kind: 'now', data: { ...standing, log, is_first: true } });
    live = told(live, { kind: 'now', data: { ...standing, log: [[3, 7, 'run', 'pause']], is_first: false } });
    expect(live.log.map(([number]) => number)).toEqual([1, 2, 3]);
    expect(lastPassage(live.log)).toEqual({ passage: { from: 'a', to: 'b.x1', cause: 'on go' }, time: 6, data: 'go' });
    live = told(live, { kind: 'gone', data: { text: 'it has gone' } });
    expect(live.why).toBe('it has gone');
    live = told(live, { kind: 'now', data: { ...standing, log: [], is_first: true } });
    expect([live.why, live.log]).toEqual(['', []]);
  });
  it('marks the transition that was taken last', () => {
    const state = { path: 'a', initial: '', is_final: false, doc: '', entry: [], exit: [], do: [], transitions: [
      { ...blankTransition('b'), on: 'go' }, { ...blankTransition('b'), when: 'x > 1', after: '3' }, blankTransition('b')] };
    const last = (cause: string) => state.transitions.map((_, index) => isLastWay(state, index, { from: 'a.in', to: 'b', cause }));
    expect(last('on go')).toEqual([true, false, false]);
    expect(last('when x > 1 after 3')).toEqual([false, true, false]);
    expect(last('at once')).toEqual([false, false, true]);
  });
});

describe('a draft beside the machine that lives', () => {
  const live = (machine: MachineRecord, edits: number) => ({ machine, edits, text: `${edits}` });
  const change = (draft: Draft | null): Draft | null => reduceDraft(draft, { kind: 'change', key: '', change: (now) => added(now, '')[0] });
  it('follows the machine until something is drawn, and is kept then', () => {
    const [one, other] = [turnstile(), removed(turnstile(), 'a')];
    const first = reduceDraft(null, { kind: 'live', live: live(one, 1) });
    expect(reduceDraft(first, { kind: 'live', live: live(other, 2) })).toMatchObject({ base: other, edits: 2 });
    const drawn = change(first);
    expect(drawn && isChanged(drawn)).toBe(true);
    expect(reduceDraft(drawn, { kind: 'live', live: live(other, 2) })).toBe(drawn);
    expect(reduceDraft(drawn, { kind: 'keep', live: live(other, 2) })).toMatchObject({ base: other, edits: 2, history: { now: drawn?.history.now } });
    expect(reduceDraft(drawn, { kind: 'discard', live: live(other, 2) })).toEqual(draftFrom(live(other, 2)));
  });
  it('gives way to the machine that it became', () => {
    const drawn = change(draftFrom(live(turnstile(), 1)));
    const applied = reduceDraft(drawn, { kind: 'applied' });
    const next = live({ ...turnstile(), doc: 'as the service writes it' }, 2);
    expect(reduceDraft(applied, { kind: 'live', live: next })).toEqual(draftFrom(next));
    expect(change(applied)?.isApplied).toBe(false);
  });
  it('is new where nothing lives, and its first steps can be taken back', () => {
    const drawn = change(newDraft());
    expect(drawn?.history.now.states).toHaveLength(1);
    expect(reduceDraft(drawn, { kind: 'undo' })?.history.now.states).toHaveLength(0);
  });
});
