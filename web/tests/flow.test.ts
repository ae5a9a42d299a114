import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';

import { curvesOf, isStale, plainText, pressureAt, shortValue } from '../src/model/flow';
import { firstText, literalOf, type Field } from '../src/model/inject';
import { KEPT_S, createValues, type Sample } from '../src/server/values';

const sample = (text: string, numbers: Sample['numbers'] = {}, more: Partial<Sample> = {}): Sample => ({ count: 1, at: 100, text, numbers, ...more });

describe('values on wires', () => {
  it('are numbers where there are some, cut to the room there is', () => {
    expect(shortValue(sample('[1.000000000] 2.34567', { data: 2.34567 }), 20)).toBe('2.35');
    expect(shortValue(sample('[1.000000000] [1, 2]', { 'data[0]': 1, 'data[1]': null }), 20)).toBe('1, –');
    expect(shortValue(sample('…', { a: 1.5, b: 22.5, c: 3 }), 8)).toBe('1.5, 22…');
    expect(shortValue(sample("[1.000000000] 'ready'"), 20)).toBe("'ready'");
    expect(shortValue({ count: 3, at: null }, 20)).toBe('');
    expect(plainText(sample('[12.000000001] <b>'))).toBe('<b>');
  });
  it('tell what is amiss at the in end', () => {
    const at = sample('', {}, { buffers: { w: [5, 8, 2], v: [4, 8, 0], one: [1, 1, 0] } });
    expect(pressureAt(at, 'w')).toEqual({ waiting: 5, length: 8, dropped: 2, isTight: true });
    expect(pressureAt(at, 'v')?.isTight).toBe(false);
    expect(pressureAt(at, 'one')?.isTight).toBe(false);
    expect(pressureAt(at, 'other')).toBeNull();
  });
  it('are stale when they came, and come no more', () => {
    expect(isStale(0, sample('1'), 101)).toBe(true);
    expect(isStale(0, { count: 0, at: null }, 101)).toBe(false);
    expect(isStale(10, sample('1'), 101)).toBe(false);
  });
  it('are stale after a while where a process that stands still tells no rate', () => {
    expect(isStale(null, sample('1'), 101)).toBe(false);
    expect(isStale(null, sample('1'), 110)).toBe(true);
    expect(isStale(null, { count: 1, at: null }, 110)).toBe(false);
  });
  it('become curves, the fields of the last one', () => {
    const samples = [sample('', { a: 1 }), sample('', { a: 2, b: null }, { at: 101 })];
    expect(curvesOf(samples)).toEqual({ names: ['a', 'b'], times: [100, 101], columns: [[1, 2], [null, null]] });
  });
});

describe('a literal from a form', () => {
  const field = (name: string, kind: Field['kind'], value: unknown, choices: string[] = []): Field => ({ name, kind, type: '', value, choices });
  it('is the data alone where there is nothing else', () => {
    expect(literalOf([field('data', 'number', 0)], { data: ' 2.5 ' })).toBe('2.5');
    expect(literalOf([field('data', 'text', '')], { data: 'a "b"' })).toBe('"a \\"b\\""');
    expect(literalOf([field('data', 'json', [])], {})).toBe('[]');
  });
  it('has nested fields as objects', () => {
    const fields = [field('velocity.vx', 'number', 0), field('velocity.on', 'truth', false), field('mode', 'choice', 'A', ['A', 'B'])];
    expect(fields.map(firstText)).toEqual(['0', 'false', 'A']);
    expect(literalOf(fields, { 'velocity.vx': '1', mode: 'B' })).toBe('{"velocity": {"vx": 1, "on": false}, "mode": "B"}');
  });
});

describe('the values that a page shows', () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  const watching = () => {
    const asked: string[][] = [];
    const post = <T>(_path: string, body: object): Promise<T> => {
      asked.push((body as { ports: string[] }).ports);
      return Promise.resolve({ values: {} } as T);
    };
    return { asked, values: createValues({ post }, 'mine') };
  };

  it('are asked for once a pause, and again after the stream has begun anew', async () => {
    const { asked, values } = watching();
    const ends = ['a', 'b'].map((port) => values.subscribe(port, () => undefined));
    values.subscribe('a', () => undefined);
    await vi.runAllTimersAsync();
    expect(asked).toEqual([]); // the server does not know the page yet
    values.begin();
    await vi.runAllTimersAsync();
    ends.forEach((end) => end());
    await vi.runAllTimersAsync();
    values.begin();
    await vi.runAllTimersAsync();
    expect(asked).toEqual([['a', 'b'], ['a'], ['a']]);
  });
  it('are kept for a minute, of the ports that somebody shows', () => {
    const { values } = watching();
    const changed = vi.fn();
    const end = values.subscribe('a', changed);
    for (const at of [0, 1, KEPT_S + 1]) values.take({ a: sample(String(at), {}, { at }), other: sample('1') });
    values.take({ a: sample('new count', {}, { at: KEPT_S + 1, count: 2 }) });
    expect(values.kept('a').map(({ at }) => at)).toEqual([1, KEPT_S + 1]);
    expect(values.latest('a')?.text).toBe('new count');
    expect(values.latest('other')).toBeUndefined();
    expect(changed).toHaveBeenCalledTimes(4);
    end();
    expect(values.latest('a')).toBeUndefined();
  });
});
