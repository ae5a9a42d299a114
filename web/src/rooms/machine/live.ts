import type { Entry, MachineRecord, Standing } from './types';

/** What the server has told of a machine. */
export interface Live {
  /** Null until it is known. */
  machine: MachineRecord | null;
  text: string;
  edits: number;
  standing: Standing | null;
  log: readonly Entry[];
  /** Why it does not answer; empty while it does. */
  why: string;
}

export const UNKNOWN: Live = { machine: null, text: '', edits: -1, standing: null, log: [], why: '' };

const KEPT = 1000;

export type Told =
  | { kind: 'machine'; data: { edits: number; text: string; machine: MachineRecord } }
  | { kind: 'now'; data: Standing & { log: Entry[]; is_first: boolean } }
  | { kind: 'gone'; data: { text: string } };

/** Puts what the server tells to what is known; a log that begins anew takes the place of the old one. */
export function told(live: Live, { kind, data }: Told): Live {
  if (kind === 'gone') return { ...live, why: data.text };
  if (kind === 'machine') return { ...live, ...data, why: '' };
  const { log, is_first: isFirst, ...standing } = data;
  const fresh = isFirst ? log : [...live.log, ...log];
  return { ...live, standing, why: '', log: log.length || isFirst ? fresh.slice(-KEPT) : live.log };
}

const TRANSITION = /^(\S+) -> (\S+): (.*)$/;
export interface Passage { from: string; to: string; cause: string }

/** The states and the cause of a transition, as the log tells them. */
export function passageOf([, , kind, text]: Entry): Passage | null {
  const [, from, to, cause] = (kind === 'transition' && TRANSITION.exec(text)) || [];
  return from !== undefined && to !== undefined && cause !== undefined ? { from, to, cause } : null;
}

/** The last transition, with the event or value that was its cause. */
export function lastPassage(log: readonly Entry[]): { passage: Passage; time: number; data: string } | null {
  for (let index = log.length - 1; index >= 0; index -= 1) {
    const entry = log[index];
    const passage = entry && passageOf(entry);
    if (!entry || !passage) continue;
    const before = log[index - 1];
    const data = before && (before[2] === 'event' || before[2] === 'value') ? before[3] : '';
    return { passage, time: entry[1], data };
  }
  return null;
}
