import { describe, expect, it } from 'vitest';

import { moved, stepOf, stepText } from '../src/rooms/plan/order';
import { placeOf, textOf } from '../src/rooms/plan/place';
import { progressOf, toldBy } from '../src/rooms/plan/progress';
import type { Plan } from '../src/rooms/plan/types';

const plan = (...texts: string[]): Plan => ({
  steps: texts.map((text, index) => ({ number: index + 1, text, kind: 'step', layer: index + 1 })), command: 'rtapply', look: 'rtplan', text: 'Apply a.yaml', notes: [],
});
const job = (status: number | null, error = '') => ({ status, error, text: 'Apply a.yaml' });

describe('how far a plan is', () => {
  it('is told step by step, and what held already took none', () => {
    const made = plan('create A on manager', 'set A.gain=1', 'activate A');
    const lines = ['[1/3] create A on manager'];
    expect([...progressOf(made, lines, job(null)).states.values()]).toEqual(['done', 'waiting', 'waiting']);
    const over = progressOf(made, [...lines, '[3/3] activate A'], job(0));
    expect([...over.states.values()]).toEqual(['done', 'held', 'done']);
    expect([over.done, over.trouble]).toEqual([3, null]);
  });

  it('knows what a start has begun', () => {
    const text = '{1} Activate /localhost/A.rtc in execution context 0';
    const line = `Executing ${text} (Required)`;
    expect([...progressOf(plan(text), [line], job(null)).states.values()]).toEqual(['begun']);
    expect([...progressOf(plan(text), [line], job(0)).states.values()]).toEqual(['done']);
  });

  it('is one tree of errors when it fails: the causes, and what is left', () => {
    const error = 'Required action failed: /localhost/A.rtc: in a bad mood; 2 steps left; run it again to go on';
    const lines = ['[1/3] create A on manager', 'left: 2 steps, cost 2 (optimal)', '1  activate A  1  A inactive -> active', '2  activate B  1', 'kept: 1 manager', error];
    const { trouble, states } = progressOf(plan('create A on manager', 'activate A', 'activate B'), lines, job(1, error));
    expect([...states.values()]).toEqual(['done', 'left', 'left']);
    expect(progressOf(plan('set A.gain=1', 'activate A', 'activate B'), [...lines.slice(1, -1), 'activate A: in a bad mood; 2 steps left'], job(1)).states)
      .toEqual(new Map([[1, 'held'], [2, 'failed'], [3, 'left']]));
    expect(trouble?.text).toBe('Apply a.yaml');
    const [cause] = trouble?.below ?? [];
    expect(cause?.text).toBe('/localhost/A.rtc: in a bad mood');
    expect(cause?.below.map((one) => one.text)).toEqual(['2 steps left', 'run it again to go on']);
    expect(cause?.below[0]?.below.map((one) => one.text)).toEqual(['activate A', 'activate B']);
  });

  it('marks the step that failed where the error names its parts', () => {
    const step = '{1} Activate /localhost/A.rtc in execution context 0';
    const error = 'Required action failed: Activate failed: /localhost/A.rtc';
    expect(progressOf(plan(step, step.replace('A.rtc', 'B.rtc')), [error], job(1, error)).states.get(1)).toBe('failed');
  });

  it('comes with the plan and the request for pages that open later', () => {
    const first = { plan: plan('a'), request: { do: 'apply', file: '/a.yaml', flags: [] } };
    const told = toldBy([first, { stderr: 'x' }, { text: 'y' }]);
    expect([told.plan, told.request, told.lines]).toEqual([first.plan, first.request, ['x']]);
    expect(toldBy([])).toEqual({ plan: null, request: null, lines: [] });
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
