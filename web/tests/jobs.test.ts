import { describe, expect, it } from 'vitest';

import type { AuditRecord } from '../src/model/types';
import { joinedChanges } from '../src/rooms/jobs/useChanges';
import { joined } from '../src/rooms/jobs/useJob';

const row = (n: number) => ({ n });

describe('rows of a job', () => {
  const none = { first: 0, rows: [], error: '' };

  it('follow each other, and count once however they came', () => {
    const kept = joined(none, { first: 0, rows: [row(0), row(1)] });
    const more = joined(kept, { first: 1, rows: [row(1), row(2)] });
    expect(more.rows).toEqual([row(0), row(1), row(2)]);
    expect(joined(more, { first: 0, rows: [row(0)] })).toBe(more);
  });

  it('begin anew after a gap', () => {
    const kept = joined(none, { first: 0, rows: [row(0)] });
    expect(joined(kept, { first: 5, rows: [row(5)] })).toEqual({ first: 5, rows: [row(5)], error: '' });
  });
});

describe('changes', () => {
  const change = (id: number, count = 1): AuditRecord => ({ id, count, time: id, page: '', by: 'script at 127.0.0.1', text: `Set ${id}`, command: '', old: null, new: `${count}`, error: '' });

  it('stand in their order, each as it was told last', () => {
    const moved = joinedChanges(joinedChanges([], [change(2), change(1, 5)]), [change(1, 4), change(2, 3)]);
    expect(moved).toEqual([change(1, 5), change(2, 3)]);
  });

  it('are forgotten with the server that told them', () => {
    expect(joinedChanges([change(1)], null)).toEqual([]);
  });
});
