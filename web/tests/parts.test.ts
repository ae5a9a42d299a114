import { describe, expect, it } from 'vitest';

import { placesIn, toggled, withoutParts } from '../src/rooms/plan/parts';
import type { Profile } from '../src/rooms/plan/types';
import type { System } from '../src/model/system';

const component = (name: string, ...sets: string[]) => ({ name, path: `localhost/${name}.rtc`, host: 'localhost', required: true, sets });
const profile: Profile = {
  components: [component('A', 'default', 'fast', '__widget__'), component('B', 'default')], variables: [], orders: {},
  connectors: [{ id: 'wire', text: 'A.out → B.in', ends: ['A', 'B'] }],
};
const asked = (...left: string[]) => withoutParts(profile, new Set(left));

describe('what is left out of a profile', () => {
  it('is told part by part', () => {
    expect(asked()).toEqual([]);
    expect(asked('wire', 'A.fast')).toEqual(['wire', 'A.fast']);
  });

  it('is told once: a component takes its connectors and sets along, all sets are one word', () => {
    expect(asked('A', 'wire', 'A.fast')).toEqual(['A']);
    expect(asked('A.fast', 'A.default', 'B.default')).toEqual(['A.*', 'B.*']);
  });

  it('is put in and taken out', () => {
    expect([...toggled(new Set(['A']), ['B', 'A'], true)]).toEqual(['A', 'B']);
    expect([...toggled(new Set(['A', 'B']), ['A'], false)]).toEqual(['B']);
  });
});

describe('where components can go', () => {
  it('is managers and their slaves, not the processes of managers', () => {
    const system = { managers: new Map([['/localhost/manager.mgr', {}]]), processes: new Map([['/localhost/manager.mgr', { id: '/localhost/manager.mgr', is_slave: false }], ['b', { id: '/localhost/manager.mgr/b.mgr', is_slave: true }]]) } as unknown as System;
    expect(placesIn(system)).toEqual(['/localhost/manager.mgr', '/localhost/manager.mgr/b.mgr']);
  });
});
