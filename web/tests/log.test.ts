import { describe, expect, it } from 'vitest';

import { lineOf, newGroup, newTerm, noFilter, recordsIn, replaced, testOf, type LogRecord, type Term } from '../src/model/logFilter';

const record = (message: string, more: Partial<LogRecord> = {}): LogRecord => ({
  time: '2026-11-28T12:00:00.000000Z', level: 'INFO', manager: 'manager', process: 'eyes', component: 'Camera0', pid: 7, host: 'localhost', source: 'rtkit', message, exception: '', ...more,
});
const term = (text: string, more: Partial<Term> = {}): Term => ({ ...newTerm(), text, ...more });
const passes = (parts: Parameters<typeof newGroup>[1], join: 'and' | 'or' = 'and') => testOf({ ...noFilter(), root: newGroup(join, parts) }).test;

describe('a filter of the log', () => {
  it('shows all while nothing is typed', () => {
    expect(testOf(noFilter()).test(record('x'))).toBe(true);
    expect(passes([term('x'), newTerm()])(record('X is there'))).toBe(true);
  });
  it('joins conditions by and, by or, and in groups', () => {
    const [one, other] = [record('low battery', { level: 'WARN' }), record('arm stuck', { level: 'ERROR', component: 'Arm0' })];
    expect(passes([term('battery'), term('WARN', { field: 'level' })])(one)).toBe(true);
    expect(passes([term('battery'), term('ERROR', { field: 'level' })])(one)).toBe(false);
    const either = passes([term('battery'), newGroup('and', [term('Arm0', { field: 'name' }), term('stuck', { field: 'message' })])], 'or');
    expect([one, other, record('arm moves', { component: 'Arm0' })].map(either)).toEqual([true, true, false]);
  });
  it('takes regular expressions, and their contrary', () => {
    const pattern = term('^arm (stuck|lost)$', { field: 'message', isPattern: true });
    expect(passes([pattern])(record('Arm lost'))).toBe(true);
    expect(passes([{ ...pattern, isNot: true }])(record('Arm lost'))).toBe(false);
    expect(passes([term('trace', { field: 'message' })])(record('x', { exception: 'Traceback' }))).toBe(true);
  });
  it('names a pattern that is none, which holds for nothing', () => {
    const { test, problem } = testOf({ ...noFilter(), root: newGroup('and', [term('(', { isPattern: true })]) });
    expect([test(record('(')), problem]).toEqual([false, '(']);
  });
  it('has bounds of time', () => {
    const range = (from: string, to: string) => testOf({ ...noFilter(), from, to }).test(record('x'));
    expect(range('2026-11-28T12:00:00Z', '2026-11-28T12:00:00Z')).toBe(true);
    expect(range('2026-11-28T12:00:01Z', '')).toBe(false);
    expect(range('', '2026-11-28T11:59:59Z')).toBe(false);
  });
  it('is a tree whose parts are replaced and removed', () => {
    const [inner, gone] = [term('a'), term('b')];
    const root = newGroup('and', [newGroup('or', [inner, gone])]);
    const changed = replaced(replaced(root, inner.id, { ...inner, text: 'c' }), gone.id, null);
    expect(JSON.stringify(changed)).toContain('"text":"c"');
    expect(JSON.stringify(changed)).not.toContain('"text":"b"');
    expect(replaced(changed, changed.parts[0]?.id ?? 0, null).parts).toHaveLength(1);
  });
  it('saves a record as a line', () => {
    expect(lineOf(record('m', { level: 'WARN', component: '' }))).toBe('2026-11-28T12:00:00.000000Z  WARN   localhost/manager  eyes  7  m');
  });
});

describe('a log that was saved', () => {
  it('is read as it was, and lines that are no records are counted', () => {
    const saved = [record('one'), record('two', { exception: 'Traceback' })];
    const text = saved.map((one) => JSON.stringify(one)).join('\n');
    expect(recordsIn(`${text}\n{"time": "cut of\n[]\n`)).toEqual({ records: saved, bad: 2 });
  });
  it('may be that of a manager', () => {
    const { records } = recordsIn('{"time": "2026-11-28T22:00:00.000000Z", "level": "INFO", "process": "manager", "pid": 7, "logger": "rtkit", "message": "ready"}\n');
    expect(records[0]).toMatchObject({ message: 'ready', source: 'rtkit', pid: 7, component: '' });
  });
  it('is nothing else', () => {
    expect(() => recordsIn('hello\n')).toThrow('no records');
  });
});
