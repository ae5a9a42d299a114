import type { Action } from './types';

/** What was done, and the actions that take it back. */
export interface Entry { label: string; actions: Action[] }

/** Actions to undo and to redo, the next one last. */
export interface History { undo: readonly Entry[]; redo: readonly Entry[] }

export type Way = 'undo' | 'redo';

export const EMPTY_HISTORY: History = { undo: [], redo: [] };

/** So many actions can be undone. */
const DEPTH = 200;

/** A new action: what could be redone before it would no longer fit. */
export const recorded = (history: History, entry: Entry): History => ({
  undo: [...history.undo, entry].slice(-DEPTH),
  redo: [],
});

/** The history after its last entry went this way; `inverse` takes that back again, null if nothing does. */
export function moved(history: History, way: Way, inverse: Entry | null): History {
  const back: Way = way === 'undo' ? 'redo' : 'undo';
  const rest = { ...history, [way]: history[way].slice(0, -1) };
  return inverse ? { ...rest, [back]: [...history[back], inverse] } : rest;
}
