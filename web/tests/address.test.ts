import { WHOLE } from '../src/model/scope';
import { describe, expect, it } from 'vitest';

import { addressOf, fragmentOf } from '../src/shell/address';

describe('the address', () => {
  it('is empty for the first view', () => {
    expect(fragmentOf(addressOf(''))).toBe('');
  });

  it('leads back to the same view', () => {
    const view = { kind: 'table', of: '', selection: ['/localhost/A&B=#.rtc', '/robot/C%2F.rtc'], filter: { text: 'x y&z', look: 'zombie', kind: 'slave' }, scope: { host: 'robot', manager: '', type: 'A B', near: '/localhost/A.rtc', steps: 3, inside: '' } } as const;
    expect(addressOf(`#${fragmentOf(view)}`)).toEqual(view);
  });

  it('names what a room is about', () => {
    const view = { kind: 'jobs', of: '3', selection: [], filter: { text: '', look: 'all', kind: 'all' }, scope: WHOLE } as const;
    expect(fragmentOf(view)).toBe('view=jobs&of=3');
    expect(addressOf('#view=jobs&of=3')).toEqual(view);
  });

  it('leaves out what it does not know', () => {
    expect(addressOf('#view=pie&state=merry&token=t')).toEqual({ kind: 'diagram', of: '', selection: [], filter: { text: '', look: 'all', kind: 'all' }, scope: WHOLE });
  });
});
