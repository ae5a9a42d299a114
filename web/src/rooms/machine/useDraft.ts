import { useCallback, useEffect, useMemo, useReducer } from 'react';

import { blankMachine } from './draft';
import { begun, redone, stepped, undone, type History } from './history';
import type { Live } from './live';
import type { MachineRecord } from './types';

/** What is drawn here and not yet in force, and the machine that it began with. */
export interface Draft {
  base: MachineRecord;
  /** The text of the base, and how many edits that had had. */
  text: string;
  edits: number;
  history: History;
  /** It was put in force: the next machine that the server tells is it. */
  isApplied: boolean;
}

export type Change = (machine: MachineRecord) => MachineRecord;
type LiveMachine = Pick<Live, 'text' | 'edits'> & { machine: MachineRecord };

export type DraftEvent =
  | { kind: 'live' | 'discard' | 'keep'; live: LiveMachine }
  | { kind: 'change'; change: Change; key: string }
  | { kind: 'undo' | 'redo' | 'applied' };

const same = (one: MachineRecord, other: MachineRecord): boolean => one === other || JSON.stringify(one) === JSON.stringify(other);

export const isChanged = ({ base, history }: Draft): boolean => !same(base, history.now);

export const draftFrom = ({ machine, text, edits }: LiveMachine): Draft => ({ base: machine, text, edits, history: begun(machine), isApplied: false });

/** A machine drawn from nothing. */
export const newDraft = (machine: MachineRecord = blankMachine()): Draft => ({ ...draftFrom({ machine: blankMachine(), text: '', edits: 0 }), history: begun(machine) });

export function reduceDraft(draft: Draft | null, event: DraftEvent): Draft | null {
  if (event.kind === 'live') {
    const { live } = event;
    if (!draft) return draftFrom(live);
    if (live.edits === draft.edits && same(live.machine, draft.base)) return draft;
    return !isChanged(draft) || draft.isApplied || same(live.machine, draft.history.now) ? draftFrom(live) : draft;
  }
  if (event.kind === 'discard') return draftFrom(event.live);
  if (!draft) return null;
  switch (event.kind) {
    case 'keep':
      return { ...draft, base: event.live.machine, text: event.live.text, edits: event.live.edits };
    case 'applied':
      return { ...draft, isApplied: true };
    case 'change':
      return { ...draft, isApplied: false, history: stepped(draft.history, event.change(draft.history.now), event.key) };
    case 'undo':
      return { ...draft, history: undone(draft.history) ?? draft.history };
    case 'redo':
      return { ...draft, history: redone(draft.history) ?? draft.history };
  }
}

/** Drafts outlive a look at another room, not a reload of the page. */
const kept = new Map<string, Draft>();

export const keepDraft = (id: string, draft: Draft): void => void kept.set(id, draft);
export const forgetDraft = (id: string): void => void kept.delete(id);

export interface Drafting {
  draft: Draft | null;
  change: (change: Change, key?: string) => void;
  undo: () => void;
  redo: () => void;
  discard: () => void;
  keep: () => void;
  applied: () => void;
}

/** The draft of a machine; of a new one where `id` is empty. */
export function useDraft(id: string, live: Live): Drafting {
  const [draft, dispatch] = useReducer(reduceDraft, null, () => kept.get(id) ?? (id ? null : newDraft()));
  const { machine, text, edits } = live;
  const known = useMemo(() => (machine ? { machine, text, edits } : null), [machine, text, edits]);
  useEffect(() => {
    if (known) dispatch({ kind: 'live', live: known });
  }, [known, draft?.isApplied]);
  useEffect(() => {
    if (draft) kept.set(id, draft);
  }, [id, draft]);
  const change = useCallback((step: Change, key = '') => dispatch({ kind: 'change', change: step, key }), []);
  return useMemo(() => ({
    draft, change,
    undo: () => dispatch({ kind: 'undo' }),
    redo: () => dispatch({ kind: 'redo' }),
    applied: () => dispatch({ kind: 'applied' }),
    discard: () => dispatch({ kind: 'discard', live: known ?? { machine: blankMachine(), text: '', edits: 0 } }),
    keep: () => known && dispatch({ kind: 'keep', live: known }),
  }), [draft, change, known]);
}
