import { describe, expect, it } from 'vitest';

import { addressOf, fragmentOf } from '../src/shell/address';

describe('the address', () => {
  it('is empty for the first view', () => {
    expect(fragmentOf(addressOf(''))).toBe('');
  });

  it('leads back to the same view', () => {
    const view = { kind: 'table', of: '', selection: ['/localhost/A&B=#.rtc', '/robot/C%2F.rtc'], filter: { text: 'x y&z', look: 'zombie' } } as const;
    expect(addressOf(`#${fragmentOf(view)}`)).toEqual(view);
  });

  it('names what a room is about', () => {
    const view = { kind: 'jobs', of: '3', selection: [], filter: { text: '', look: 'all' } } as const;
    expect(fragmentOf(view)).toBe('view=jobs&of=3');
    expect(addressOf('#view=jobs&of=3')).toEqual(view);
  });

  it('leaves out what it does not know', () => {
    expect(addressOf('#view=pie&state=merry&token=t')).toEqual({ kind: 'diagram', of: '', selection: [], filter: { text: '', look: 'all' } });
  });
});
