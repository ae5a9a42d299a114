import { EMPTY_SYSTEM, reduceSystem, type System } from './system';
import type { Change, Picture } from './types';

/** What the server keeps: the picture before the first change, and all changes since. */
export interface Kept { since: number; picture: Picture; changes: Change[] }

/** Folding begins at the nearest of these: one for each so many changes. */
const STRIDE = 64;

/** The past of a system, folded from kept changes as the live one is. */
export interface Past {
  since: number;
  /** The times of all changes, oldest first. */
  times: readonly number[];
  /** What was at a moment; null before the first one that is known. */
  at: (time: number) => System | null;
  /** Since when the boxes and wires of a moment were the same; null for those of the present. */
  layoutAt: (time: number) => number | null;
  /** Adds what happens from now on; what is known already is left out. */
  add: (change: Change) => void;
}

export function pastOf({ since, picture, changes }: Kept): Past {
  const first = { ...reduceSystem(EMPTY_SYSTEM, { kind: 'picture', picture }), isReadOnly: true, jobs: EMPTY_SYSTEM.jobs };
  const kept = [...changes];
  const times = kept.map(({ time }) => time);
  /** The system after 0, 64, 128 … changes, as far as somebody has looked. */
  const steps: System[] = [first];
  /** The time of the first change after which the structure had this number. */
  const structures = new Map<number, number>([[first.structure, since]]);

  const fold = (system: System, from: number, to: number): System => {
    let folded = system;
    for (const change of kept.slice(from, to)) {
      folded = reduceSystem(folded, { kind: 'change', change });
      if (!structures.has(folded.structure)) structures.set(folded.structure, change.time);
    }
    return folded;
  };
  const after = (count: number): System => {
    const step = Math.floor(count / STRIDE);
    for (let next = steps.length; next <= step; next += 1) steps.push(fold(steps.at(-1) ?? first, (next - 1) * STRIDE, next * STRIDE));
    return fold(steps[step] ?? first, step * STRIDE, count);
  };
  const at = (time: number) => (time < since ? null : after(countUpTo(times, time)));
  return {
    since, times, at,
    layoutAt: (time) => {
      const structure = at(time)?.structure;
      if (structure === undefined || structure === after(kept.length).structure) return null;
      return structures.get(structure) ?? null;
    },
    add: (change) => {
      if (change.revision <= (kept.at(-1)?.revision ?? picture.revision)) return;
      kept.push(change);
      times.push(change.time);
    },
  };
}

/** How many of some times, in their order, are not after a moment. */
export function countUpTo(times: readonly number[], time: number): number {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The moment that a key of the time line goes to; null for the present. */
export function neighbour(times: readonly number[], since: number, time: number | null, key: string): number | null {
  const count = time === null ? times.length : countUpTo(times, time);
  const back = { ArrowLeft: 1, ArrowDown: 1, PageDown: 10, Home: Infinity }[key];
  const on = { ArrowRight: 1, ArrowUp: 1, PageUp: 10, End: Infinity }[key];
  // From the present, or between two changes, one step back is to before the last change that shows.
  if (back !== undefined) return times[Math.max(count - 1 - back, -1)] ?? since;
  if (on === undefined || time === null) return time;
  return count + on > times.length ? null : (times[count - 1 + on] ?? null);
}
