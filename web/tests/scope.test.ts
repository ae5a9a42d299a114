import { describe, expect, it } from 'vitest';

import { pairsOf } from '../src/model/ports';
import { WHOLE, narrowed, scoped, wayTo } from '../src/model/scope';
import { EMPTY_SYSTEM, reduceSystem } from '../src/model/system';
import { component, picture, wire } from './records';

const id = (name: string) => `/localhost/${name}.rtc`;
const system = reduceSystem(EMPTY_SYSTEM, {
  kind: 'picture',
  picture: picture({
    components: [
      ...['A0', 'B0', 'C0', 'D0'].map((name) => component(name)),
      component('Inner0', { composite: id('Whole0'), members: [id('E0')], is_composite: true }), component('Whole0', { members: [id('Inner0')], is_composite: true }),
      component('E0', { composite: id('Inner0') }),
    ],
    connectors: [wire('1', 'A0.out', 'B0.in'), wire('2', 'B0.out', 'C0.in'), wire('3', 'D0.out', 'E0.in')],
  }),
});
const names = (scope: object) => [...(scoped({ ...WHOLE, ...scope }, system) ?? ['all'])].map((one) => one.replace(/.*\/|\.rtc/g, ''));

describe('a scope', () => {
  it('is everything without a limit', () => {
    expect(names({})).toEqual(['all']);
    expect(narrowed(system, null)).toBe(system);
  });

  it('goes along connectors, both ways, so many steps', () => {
    expect(names({ near: id('A0') })).toEqual(['A0', 'B0']);
    expect(names({ near: id('C0'), steps: 2 })).toEqual(['A0', 'B0', 'C0']);
    expect(names({ near: id('D0'), steps: 9 })).toEqual(['D0', 'Inner0', 'E0']);
    expect([...narrowed(system, scoped({ ...WHOLE, near: id('A0') }, system)).connectors.keys()]).toEqual(['1']);
  });

  it('narrows by type, and to what is in a composite', () => {
    expect(names({ type: 'B' })).toEqual(['B0']);
    expect(names({ host: 'robot' })).toEqual([]);
    expect(names({ inside: id('Whole0') })).toEqual(['Inner0', 'E0']);
    expect(wayTo(id('Inner0'), system.components).map((one) => one.name)).toEqual(['Whole0', 'Inner0']);
  });
});

describe('interfaces', () => {
  it('belong together by type, provided with required', () => {
    const service = (polarity: 'Provided' | 'Required', type: string, instance: string) => ({ name: 'p', direction: 'service' as const, type: '', interfaces: [{ instance, type, polarity }] });
    const own = service('Provided', 'MyService', 'a');
    expect(pairsOf(own, service('Required', 'MyService', 'b')).map(([one, other]) => [one.instance, other.instance])).toEqual([['a', 'b']]);
    expect(pairsOf(own, service('Provided', 'MyService', 'b'))).toEqual([]);
    expect(pairsOf(own, service('Required', 'Other', 'b'))).toEqual([]);
    expect(pairsOf(own, undefined)).toEqual([]);
  });
});
