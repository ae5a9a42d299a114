import { describe, expect, it } from 'vitest';

import { moved, stepOf, stepText } from '../src/rooms/plan/order';
import { placeOf, textOf } from '../src/rooms/plan/place';
import { progressOf, toldBy } from '../src/rooms/plan/progress';
import type { JobRow } from '../src/model/types';
import type { Plan, PlanStep } from '../src/rooms/plan/types';

const step = (number: number, text: string): PlanStep => ({ number, text, kind: 'create', layer: number, subject: 'A', cost: 1, cost_from: 'table', change: '' });
const plan = (...texts: string[]): Plan => ({ steps: texts.map((text, index) => step(index + 1, text)), cost: texts.length, command: 'rtapply', look: 'rtplan', text: 'Apply a.yaml', notes: [] });
const about = (made: Plan) => ({ plan: made, request: { do: 'apply', file: '/a.yaml', flags: [] } });
const planned = (made: Plan, reason?: string) => ({ schema: 'rtkit.plan/1', steps: made.steps, ...(reason && { reason }) });
const told = (number: number, state: string, why = '', took: number | null = null) => ({ schema: 'rtkit.step/1', number, state, why, took_s: took });
const job = (status: number | null, error = '') => ({ status, error, text: 'Apply a.yaml' });
const states = (rows: JobRow[], status: number | null, error = '') => progressOf(toldBy(rows).parts, job(status, error)).parts.map(({ news }) => [...news.values()].map(({ state }) => state));

describe('how far a plan is', () => {
  const made = plan('create A', 'set A.gain=1', 'activate A');

  it('is told step by step, and what nothing was told of held already when all is done', () => {
    const rows = [about(made), planned(made), told(1, 'begun'), told(1, 'done', '', 0.25), told(3, 'begun')];
    expect(states(rows, null)).toEqual([['done', 'waiting', 'begun']]);
    expect(states(rows, 0)).toEqual([['done', 'held', 'done']]);
    const { parts, done, all, trouble } = progressOf(toldBy(rows).parts, job(0));
    expect([done, all, trouble, parts[0]?.news.get(1)?.tookS]).toEqual([3, 3, null, 0.25]);
  });

  it('is one tree of errors when it fails: each step with its cause, what the command said, what is left', () => {
    const error = 'note: x\nset A.gain=1: no such parameter; 2 steps left';
    const rows = [about(made), planned(made), told(1, 'done'), told(2, 'begun'), told(2, 'failed', 'no such parameter')];
    expect(states(rows, 1, error)).toEqual([['done', 'failed', 'left']]);
    expect(progressOf(toldBy(rows).parts, job(1, error)).trouble).toEqual({ text: 'Apply a.yaml', below: [
      { text: 'set A.gain=1', below: [{ text: 'no such parameter', below: [] }] },
      { text: '2 steps left', below: [] },
      { text: '', left: 1, below: [{ text: 'activate A', below: [] }] },
    ] });
  });

  it('tells what the command said when it fails before any step', () => {
    expect(progressOf(toldBy([about(made)]).parts, job(1, 'a\nb')).trouble?.below.map(({ text }) => text)).toEqual(['a', 'b', '']);
  });

  it('tells what failed though the rest was done', () => {
    expect(progressOf(toldBy([about(made), told(1, 'failed', 'gone'), told(2, 'done'), told(3, 'done')]).parts, job(0)).trouble?.below).toHaveLength(1);
  });

  it('has a part for each time that it was planned anew', () => {
    const back = plan('delete A');
    const rows = [about(made), planned(made), told(1, 'done'), told(2, 'failed', 'no'), planned(back, 'way back'), told(1, 'done')];
    expect(toldBy(rows).parts.map(({ reason }) => reason)).toEqual(['', 'way back']);
    expect(states(rows, 1)).toEqual([['done', 'failed', 'left'], ['done']]);
  });

  it('comes with the plan, the request and notes for pages that open later', () => {
    const first = about(made);
    const { plan: known, request, notes } = toldBy([first, { stderr: 'x' }, { text: 'y' }]);
    expect([known, request, notes]).toEqual([first.plan, first.request, ['x']]);
    expect(toldBy([])).toMatchObject({ plan: null, request: null, notes: [] });
  });
});

describe('the place in the room', () => {
  it('is told by the address', () => {
    for (const text of ['do:/a/b.yaml', 'job:3', 'compare:/a.yaml|/b.yaml', 'order:/a.yaml', 'do:']) expect(textOf(placeOf(text))).toBe(text);
    expect(placeOf('')).toEqual({ tab: 'do', of: '', other: '' });
  });
});

describe('steps of an order', () => {
  it('are read and written as the command has them', () => {
    for (const text of ['A', 'A@1:at=3', 'A:wait=500', 'A:after=B,after=C,timeout=100,sent']) expect(stepText(stepOf(text))).toBe(text);
    expect(stepText({ ...stepOf('A:wait=5'), after: ['B'] })).toBe('A:after=B');
  });

  it('move', () => {
    expect(moved(['a', 'b', 'c'], 2, 0)).toEqual(['c', 'a', 'b']);
    expect(moved(['a', 'b'], 0, -1)).toEqual(['a', 'b']);
  });
});
