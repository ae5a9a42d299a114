import { describe, expect, it } from 'vitest';

import { mergedForms } from '../src/rooms/builder/merge';

const base = { basicInfo: { name: 'A', version: '1' }, dataPorts: [{ name: 'in', type: 'T' }, { name: 'out', type: 'T' }] };

describe('two forms of one profile', () => {
  it('come together where they do not touch', () => {
    const mine = { ...base, basicInfo: { name: 'A', version: '2' }, dataPorts: [{ name: 'in', type: 'U' }, { name: 'out', type: 'T' }] };
    const theirs = { ...base, basicInfo: { name: 'A', version: '1', vendor: 'they' }, dataPorts: [{ name: 'in', type: 'T' }, { name: 'new', type: 'T' }] };
    expect(mergedForms(base, mine, theirs)).toEqual({
      form: { basicInfo: { name: 'A', version: '2', vendor: 'they' }, dataPorts: [{ name: 'in', type: 'U' }, { name: 'new', type: 'T' }] }, conflicts: [],
    });
  });

  it('keep mine where both changed the same, and say where', () => {
    const mine = { ...base, basicInfo: { name: 'A', version: '2' } };
    const theirs = { ...base, basicInfo: { name: 'A', version: '3' } };
    expect(mergedForms(base, mine, theirs)).toEqual({ form: mine, conflicts: ['basicInfo.version'] });
  });

  it('are what changed, if one is as before', () => {
    const other = { basicInfo: { name: 'B' } };
    expect(mergedForms(base, base, other).form).toEqual(other);
    expect(mergedForms(base, other, base).form).toEqual(other);
  });

  it('say where one has removed what the other changed', () => {
    const mine = { ...base, dataPorts: [{ name: 'out', type: 'T' }] };
    const theirs = { ...base, dataPorts: [{ name: 'in', type: 'V' }, { name: 'out', type: 'T' }] };
    expect(mergedForms(base, mine, theirs)).toEqual({ form: mine, conflicts: ['dataPorts.in'] });
  });
});
