import type { Action } from './types';

/**
 * What was done, the actions that take it back, and why that was refused when it was tried last.
 * `change` is the number that the server gives a value that is being moved: all its steps are one entry.
 */
export interface Entry { label: string; actions: Action[]; refusal?: string; change?: number }

/** Actions to undo and to redo, the next one last. */
export interface History { undo: readonly Entry[]; redo: readonly Entry[] }

export type Way = 'undo' | 'redo';

export const EMPTY_HISTORY: History = { undo: [], redo: [] };

/** So many actions can be undone. */
const DEPTH = 200;

/** A new action: what could be redone before it would no longer fit. */
export function recorded(history: History, entry: Entry): History {
  const goesOn = entry.change !== undefined && history.undo.some(({ change }) => change === entry.change);
  const undo = goesOn ? history.undo.map((one) => (one.change === entry.change ? entry : one)) : [...history.undo, entry];
  return { undo: undo.slice(-DEPTH), redo: [] };
}

/** The history after its last entry went this way; `inverse` takes that back again, null if nothing does; `left` is what could not be done of it. */
export function moved(history: History, way: Way, inverse: Entry | null, left: Entry | null = null): History {
  const back: Way = way === 'undo' ? 'redo' : 'undo';
  const rest = { ...history, [way]: [...history[way].slice(0, -1), ...(left ? [left] : [])] };
  return inverse ? { ...rest, [back]: [...history[back], inverse] } : rest;
}
