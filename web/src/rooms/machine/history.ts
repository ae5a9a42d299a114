import type { MachineRecord } from './types';

/** A machine with what it was before: each step has a key, and steps of one key that follow each other are one. */
export interface History { past: readonly MachineRecord[]; now: MachineRecord; future: readonly MachineRecord[]; key: string }

const MOST = 200;

export const begun = (now: MachineRecord): History => ({ past: [], now, future: [], key: '' });

/** Another machine. What is typed into one field has one key, so that undo takes back a word and not a letter. */
export function stepped(history: History, now: MachineRecord, key = ''): History {
  if (now === history.now) return history;
  const past = key && key === history.key ? history.past : [...history.past, history.now].slice(-MOST);
  return { past, now, future: [], key };
}

export function undone({ past, now, future }: History): History | null {
  const before = past.at(-1);
  return before ? { past: past.slice(0, -1), now: before, future: [now, ...future], key: '' } : null;
}

export function redone({ past, now, future }: History): History | null {
  const [next, ...rest] = future;
  return next ? { past: [...past, now], now: next, future: rest, key: '' } : null;
}
