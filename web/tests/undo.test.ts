import { describe, expect, it } from 'vitest';

import { EMPTY_HISTORY, moved, recorded, type Entry } from '../src/model/undo';

const entry = (label: string): Entry => ({ label, actions: [{ do: 'disconnect', connector: label }] });
const both = recorded(recorded(EMPTY_HISTORY, entry('a')), entry('b'));

describe('undo and redo', () => {
  it('undoes the last action first, and redoes by the inverse of the undo', () => {
    const undone = moved(both, 'undo', entry('b again'));
    expect(undone.undo).toEqual([entry('a')]);
    expect(undone.redo).toEqual([entry('b again')]);
    expect(moved(undone, 'redo', entry('b'))).toEqual(both);
  });

  it('keeps what was refused, with the reason', () => {
    const left = { ...entry('b'), refusal: 'it is 9, not 7' };
    expect(moved(both, 'undo', null, left)).toEqual({ undo: [entry('a'), left], redo: [] });
  });

  it('drops what has no inverse any more', () => {
    expect(moved(both, 'undo', null)).toEqual({ undo: [entry('a')], redo: [] });
  });

  it('takes a value that is moved back in one step, whatever else is done meanwhile', () => {
    const move = (to: string): Entry => ({ label: 'Set a', change: 7, actions: [{ do: 'set', target: 'a', value: '0', expect: to }] });
    const history = [move('1'), entry('b'), move('2')].reduce(recorded, EMPTY_HISTORY);
    expect(history.undo).toEqual([move('2'), entry('b')]);
  });

  it('forgets what could be redone when something new is done', () => {
    const undone = moved(both, 'undo', entry('b'));
    expect(recorded(undone, entry('c'))).toEqual({ undo: [entry('a'), entry('c')], redo: [] });
  });
});
