import { describe, expect, it } from 'vitest';

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
