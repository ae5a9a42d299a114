import { describe, expect, it } from 'vitest';

import { EMPTY_SYSTEM, EVENTS_KEPT, reduceSystem } from '../src/model/system';
import { NOTHING_GONE, change, component, picture, port, wire } from './records';

const motor = component('Motor0', { ports: [port('speed', 'in')] });
const sensor = component('Sensor0', { ports: [port('out', 'out')] });
const begun = reduceSystem(EMPTY_SYSTEM, { kind: 'picture', picture: picture({ components: [motor, sensor], connectors: [wire('w', 'Sensor0.out', 'Motor0.speed')] }) });
const after = (revision: number, more: Parameters<typeof change>[1]) => reduceSystem(begun, { kind: 'change', change: change(revision, more) });

describe('the picture of the system', () => {
  it('takes all records of a picture and is known from then on', () => {
    expect([...begun.components.keys()]).toEqual([motor.id, sensor.id]);
    expect([begun.isKnown, EMPTY_SYSTEM.isKnown]).toEqual([true, false]);
  });

  it('forgets what a later picture does not hold', () => {
    const next = reduceSystem(begun, { kind: 'picture', picture: picture({ revision: 9, components: [sensor] }) });
    expect([...next.components.keys()]).toEqual([sensor.id]);
    expect(next.connectors.size).toBe(0);
  });

  it('replaces records that changed and keeps the identity of the others', () => {
    const next = after(2, { components: [{ ...motor, state: 'Active', look: 'active' }] });
    expect(next.components.get(motor.id)?.state).toBe('Active');
    expect(next.components.get(sensor.id)).toBe(sensor);
    expect(next.connectors).toBe(begun.connectors);
  });

  it('removes what has gone', () => {
    const next = after(2, { gone: { ...NOTHING_GONE, components: [motor.id], connectors: ['w'] } });
    expect([next.components.has(motor.id), next.connectors.size]).toEqual([false, 0]);
  });

  it('ignores a change that the picture already holds', () => {
    expect(after(1, { gone: { ...NOTHING_GONE, components: [motor.id] } })).toBe(begun);
  });

  it('wants a new layout for ports, boxes and wires, not for states', () => {
    expect(after(2, { components: [{ ...motor, state: 'Error', look: 'error' }] }).structure).toBe(begun.structure);
    expect(after(2, { components: [{ ...motor, ports: [] }] }).structure).toBe(begun.structure + 1);
    expect(after(2, { connectors: [wire('v', 'Sensor0.out', 'Motor0.speed')] }).structure).toBe(begun.structure + 1);
    expect(after(2, { gone: { ...NOTHING_GONE, connectors: ['w'] } }).structure).toBe(begun.structure + 1);
  });

  it('keeps the newest events only', () => {
    const events = Array.from({ length: EVENTS_KEPT + 5 }, (_, time) => ({ time, kind: '', path: '', subject: '', event: '', detail: '' }));
    const next = after(2, { events });
    expect([next.events.length, next.events.at(-1)?.time]).toEqual([EVENTS_KEPT, EVENTS_KEPT + 4]);
  });
});
