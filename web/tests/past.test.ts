import { describe, expect, it } from 'vitest';

import { countUpTo, neighbour, pastOf } from '../src/model/past';
import { EMPTY_SYSTEM, reduceSystem } from '../src/model/system';
import type { Change } from '../src/model/types';
import { NOTHING_GONE, change, component, picture, wire } from './records';

/** Two hundred changes: states that turn, and every tenth time a component that comes or goes. */
function changes(): Change[] {
  return Array.from({ length: 200 }, (_, index) => {
    const time = 100 + index;
    if (index % 20 === 10) return change(index + 2, { time, components: [component(`New${index}`)], connectors: [wire(`w${index}`, `New${index}.a`, 'A.b')] });
    if (index % 20 === 0 && index) return change(index + 2, { time, gone: { ...NOTHING_GONE, components: [`/localhost/New${index - 10}.rtc`] } });
    return change(index + 2, { time, components: [component('A', { since: index })], events: [{ time, kind: 'RTC_STATUS', path: 'A', subject: '', event: 'ACTIVE', detail: '' }] });
  });
}

describe('the past', () => {
  const first = picture({ components: [component('A')] });
  it('is what the live page showed, at any moment and in any order', () => {
    const all = changes();
    const past = pastOf({ since: 99, picture: first, changes: all });
    const live = [reduceSystem(EMPTY_SYSTEM, { kind: 'picture', picture: first })];
    for (const one of all) live.push(reduceSystem(live.at(-1) ?? EMPTY_SYSTEM, { kind: 'change', change: one }));
    for (const count of [200, 0, 63, 64, 65, 10, 11, 128, 199]) {
      const { components, connectors, events } = past.at(count ? 99.5 + count : 99) ?? EMPTY_SYSTEM;
      expect({ components, connectors, events }).toEqual({ components: live[count]?.components, connectors: live[count]?.connectors, events: live[count]?.events });
    }
    expect(past.at(98)).toBeNull();
    expect(past.at(99)?.isReadOnly).toBe(true);
  });
  it('asks for another layout only where boxes or wires were others', () => {
    const past = pastOf({ since: 99, picture: first, changes: changes() });
    expect(past.layoutAt(99)).toBe(99);
    expect(past.layoutAt(109.9)).toBe(99);
    expect(past.layoutAt(110)).toBe(110);
    expect(past.layoutAt(119.5)).toBe(110);
    expect(past.layoutAt(299)).toBeNull();
  });
  it('goes on with what happens, and counts nothing twice', () => {
    const past = pastOf({ since: 99, picture: first, changes: changes() });
    past.add(change(201, { time: 299 }));
    past.add(change(202, { time: 300, components: [component('B')] }));
    expect(past.times.length).toBe(201);
    expect(past.at(300)?.components.has('/localhost/B.rtc')).toBe(true);
    expect(past.at(299)?.components.has('/localhost/B.rtc')).toBe(false);
  });
});

describe('the keys of the time line', () => {
  const times = [1, 2, 3, 4];
  it.each([
    [null, 'ArrowLeft', 3], [null, 'ArrowRight', null], [3, 'ArrowLeft', 2], [3.5, 'ArrowLeft', 2], [1, 'ArrowLeft', 0], [0, 'ArrowLeft', 0],
    [0, 'ArrowRight', 1], [3, 'ArrowRight', 4], [4, 'ArrowRight', null], [3, 'Home', 0], [2, 'End', null], [null, 'PageDown', 0],
  ])('from %s by %s to %s', (time, key, to) => {
    expect(neighbour(times, 0, time, key)).toBe(to);
  });
  it('count changes up to a moment', () => {
    expect([0, 1, 2.5, 9].map((time) => countUpTo(times, time))).toEqual([0, 1, 2, 4]);
  });
});
