import type { Action } from './types';

/** What was done, the actions that take it back, and why that was refused when it was tried last. */
export interface Entry { label: string; actions: Action[]; refusal?: string }

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

/** The history after its last entry went this way; `inverse` takes that back again, null if nothing does; `left` is what could not be done of it. */
export function moved(history: History, way: Way, inverse: Entry | null, left: Entry | null = null): History {
  const back: Way = way === 'undo' ? 'redo' : 'undo';
  const rest = { ...history, [way]: [...history[way].slice(0, -1), ...(left ? [left] : [])] };
  return inverse ? { ...rest, [back]: [...history[back], inverse] } : rest;
}
