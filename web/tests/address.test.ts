import { describe, expect, it } from 'vitest';

import { addressOf, fragmentOf } from '../src/shell/address';

describe('the address', () => {
  it('is empty for the first view', () => {
    expect(fragmentOf(addressOf(''))).toBe('');
  });

  it('leads back to the same view', () => {
    const view = { kind: 'table', selection: ['/localhost/A&B=#.rtc', '/robot/C%2F.rtc'], filter: { text: 'x y&z', look: 'zombie' } } as const;
    expect(addressOf(`#${fragmentOf(view)}`)).toEqual(view);
  });

  it('leaves out what it does not know', () => {
    expect(addressOf('#view=pie&state=merry&token=t')).toEqual({ kind: 'diagram', selection: [], filter: { text: '', look: 'all' } });
  });
});
