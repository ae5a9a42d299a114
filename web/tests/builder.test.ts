import { describe, expect, it } from 'vitest';

import { compared, counted, firstChange, near } from '../src/rooms/builder/difference';
import { begun, edited, redone, undone } from '../src/rooms/builder/draft';
import { findingsBelow, freeName, propertyAt, rowsAt, textAt, withMovedRow, withProperty, withRow, withValue, withoutRow, type Form } from '../src/rooms/builder/form';
import { ownLines, tokens } from '../src/rooms/builder/highlight';

const FORM: Form = { basicInfo: { name: 'Gain' }, dataPorts: [{ name: 'in' }, { name: 'out' }] };

describe('a form', () => {
  it('is changed at one place, and what it shares stays the same', () => {
    const after = withValue(FORM, 'dataPorts.1.name', 'result');
    expect(rowsAt(after, 'dataPorts').map((row) => row.name)).toEqual(['in', 'result']);
    expect(after.basicInfo).toBe(FORM.basicInfo);
    expect(textAt(FORM, 'dataPorts.1.name')).toBe('out');
  });

  it('gets parts on the way, and loses those that become empty', () => {
    const place = 'basicInfo.rtcDoc::doc.license';
    const after = withValue(FORM, place, 'MIT');
    expect(textAt(after, place)).toBe('MIT');
    expect(withValue(after, place, undefined)).toEqual(FORM);
  });

  it('has lists whose rows are added, moved and removed', () => {
    const after = withRow(FORM, 'dataPorts', { name: 'more' });
    expect(rowsAt(withMovedRow(after, 'dataPorts', 2, -1), 'dataPorts').map((row) => row.name)).toEqual(['in', 'more', 'out']);
    expect(withMovedRow(after, 'dataPorts', 0, -1)).toBe(after);
    expect(withoutRow(after, 'dataPorts', 2)).toEqual(FORM);
    expect(withoutRow(withoutRow(FORM, 'dataPorts', 0), 'dataPorts', 0)).toEqual({ basicInfo: { name: 'Gain' } });
  });

  it('keeps extension properties by name', () => {
    const after = withProperty(FORM, 'dataPorts.0', '__widget__', 'spin');
    expect(propertyAt(after, 'dataPorts.0', '__widget__')).toBe('spin');
    expect(withProperty(after, 'dataPorts.0', '__widget__', '')).toEqual(FORM);
  });

  it('gives names that are free, and findings by part', () => {
    expect(freeName(['in', 'in2'], 'in')).toBe('in3');
    const findings = [{ place: 'dataPorts.1.name', level: 'error', text: '' }, { place: 'dataPortsX', level: 'error', text: '' }] as const;
    expect(findingsBelow(findings, 'dataPorts')).toHaveLength(1);
  });
});

describe('a draft', () => {
  const named = (name: string) => withValue(FORM, 'basicInfo.name', name);

  it('takes typing in one field for one step', () => {
    let draft = begun(FORM, '', '');
    for (const name of ['G', 'Ge', 'Get']) draft = edited(draft, named(name), 'basicInfo.name');
    draft = edited(draft, withRow(draft.form, 'dataPorts', {}), '');
    draft = undone(draft);
    expect(draft.form).toEqual(named('Get'));
    draft = undone(draft);
    expect(draft.form).toEqual(FORM);
    expect(undone(draft)).toBe(draft);
    expect(redone(draft).form).toEqual(named('Get'));
    expect(redone(edited(draft, named('Other'), '')).form).toEqual(named('Other'));
  });
});

describe('a comparison', () => {
  const kinds = (before: string, after: string) => compared(before, after).map((row) => row.kind);

  it('pairs lines that take the place of others', () => {
    expect(kinds('a\nb\nc\n', 'a\nB\nc\nd\n')).toEqual(['same', 'changed', 'same', 'added']);
    expect(kinds('a\nb\n', 'b\n')).toEqual(['removed', 'same']);
    expect(kinds('', 'a\n')).toEqual(['added']);
    expect(kinds('a\n', 'a\n')).toEqual(['same']);
    expect(counted(compared('a\nb\n', 'a\nc\nd\n'))).toEqual({ added: 2, removed: 1 });
  });

  it('tells both texts whole, whatever they are', () => {
    let seed = 7;
    const next = (n: number) => (seed = (seed * 48271) % 2147483647) % n;
    for (let round = 0; round < 200; round += 1) {
      const [before, after] = [0, 1].map(() => Array.from({ length: next(14) }, () => 'abcd'[next(4)]).join('\n'));
      const rows = compared(before ?? '', after ?? '');
      expect(rows.flatMap((row) => row.old?.text ?? []).join('\n')).toBe(before);
      expect(rows.flatMap((row) => row.new?.text ?? []).join('\n')).toBe(after);
      expect(rows.every((row) => row.kind !== 'same' || row.old?.text === row.new?.text)).toBe(true);
    }
  });

  it('finds what has just changed, but for the stamp', () => {
    const stamp = (digit: string) => `# Made by rtbuild: … [${digit.repeat(12)}].\n`;
    expect(firstChange(`${stamp('1')}a\nb\n`, `${stamp('2')}a\nx\nb\n`)).toBe(2);
  });

  it('leaves out what is far from any change', () => {
    const before = Array.from({ length: 20 }, (_, n) => `line ${n}`).join('\n');
    const rows = near(compared(before, before.replace('line 10\n', 'other\n')));
    expect(rows[0]).toBe(7);
    expect(rows.at(-1)).toBe(6);
    expect(rows).toHaveLength(9);
  });
});

describe('code', () => {
  it('is told in pieces that are the whole line', () => {
    for (const [line, file] of [['    def f(self) -> None:  # "x"', 'a.py'], ['<a b="c"/>', 'a.xml'], ['name = "x"  # y', 'a.toml'], ['plain', 'README.md']] as const) {
      expect(tokens(line, file).map((token) => token.text).join('')).toBe(line);
    }
    expect(tokens('return "a # b"', 'a.py').map((token) => token.kind)).toEqual(['word', 'plain', 'text']);
  });

  it('shows which lines are the user’s', () => {
    expect(ownLines(['a', '  # <user code x>', '  mine', '  # </user code x>', 'b'])).toEqual([false, false, true, false, false]);
  });
});
