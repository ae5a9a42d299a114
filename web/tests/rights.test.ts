import { expect, test } from 'vitest';

import { lackingAt, lackingFor, managersAt } from '../src/model/rights';
import { EMPTY_SYSTEM, reduceSystem } from '../src/model/system';
import type { Manager, Rights } from '../src/model/types';
import { component, picture, wire } from './records';

const manager = (id: string, rights: Rights | null): Manager => ({ id, name: 'manager', host: 'h', pid: 1, version: '1', state: 'up', why: '', rights });

function systemWith(role: Rights['role']) {
  const far = manager('/robot/manager.mgr', { name: 'bert', role });
  const parts = [component('A'), { ...component('B'), manager: far.id }];
  const own = manager('/localhost/manager.mgr', null);
  return reduceSystem(EMPTY_SYSTEM, { kind: 'picture', picture: picture({ managers: [own, far], components: parts, connectors: [wire('w', 'A.out', 'B.in')] }) });
}
const [A, B, OWN, FAR] = ['/localhost/A.rtc', '/localhost/B.rtc', '/localhost/manager.mgr', '/robot/manager.mgr'];

test('a viewer changes nothing where it is viewer, and all at managers of its own', () => {
  const system = systemWith('viewer');
  for (const ids of [[B], [A, B], ['w'], [FAR]]) expect(lackingAt(system, ids, 'operator')?.id).toBe(FAR);
  for (const ids of [[A], [OWN], []]) expect(lackingAt(system, ids, 'administrator')).toBeUndefined();
});

test('an operator changes what is there, and makes and ends nothing', () => {
  const system = systemWith('operator');
  expect(lackingAt(system, [B, 'w'], 'operator')).toBeUndefined();
  expect(lackingAt(system, [B], 'administrator')?.id).toBe(FAR);
  expect(lackingAt(systemWith('administrator'), [B], 'administrator')).toBeUndefined();
});

test('a property belongs to the managers at its place, a service without a place to none', () => {
  const system = systemWith('viewer');
  expect(managersAt(system, '/robot/B.rtc.configuration.default.x')).toEqual([FAR]);
  expect(managersAt(system, '/localhost/A.rtc.state')).toEqual([OWN]);
  expect(managersAt(system, 'robots/r1.speed')).toEqual([]);
});

test('a plan is for who may do it at the hosts that it names, or at one of all', () => {
  const system = systemWith('operator');
  expect(lackingFor(system, 'administrator', new Set(['robot']))?.id).toBe(FAR);
  expect(lackingFor(system, 'operator', new Set(['robot']))).toBeUndefined();
  expect(lackingFor(system, 'administrator', new Set(['elsewhere']))).toBeUndefined();
  const far = { ...system, managers: new Map([...system.managers].filter(([id]) => id === FAR)) };
  expect(lackingFor(far, 'administrator', new Set())?.id).toBe(FAR);
});
