import type { Point } from '../../model/types';

export interface ActionRecord {
  kind: 'set' | 'assign' | 'raise';
  /** Property, variable or event. */
  target: string;
  how: 'value' | 'expression' | 'get';
  value: string;
  /** Period of an action that is repeated [s]; empty for the usual one. */
  every: string;
}
export interface TransitionRecord { to: string; on: string; when: string; after: string; actions: readonly ActionRecord[] }
export interface StateRecord {
  /** Names of the states round it and its own, with dots. */
  path: string;
  initial: string;
  is_final: boolean;
  doc: string;
  entry: readonly ActionRecord[];
  exit: readonly ActionRecord[];
  do: readonly ActionRecord[];
  transitions: readonly TransitionRecord[];
}
export interface VariableRecord { name: string; value: string }
/** A machine as the server tells and takes it; a state stands behind the one round it. */
export interface MachineRecord { name: string; doc: string; initial: string; variables: readonly VariableRecord[]; states: readonly StateRecord[] }

/** Something wrong, or odd, in a draft; `state` is empty for the machine itself. */
export interface Problem { state: string; part: string; text: string; is_odd: boolean }

export interface ChartBox {
  x: number; y: number; width: number; height: number; parent: string | null; kind: 'state' | 'composite';
  summary: string;
  /** Height of the head; below it stand the texts of the transitions, in rows of 20 px. */
  head: number;
  rows: string[];
}
export interface ChartLayout { width: number; height: number; boxes: Record<string, ChartBox>; paths: Record<string, Point[]> }
/** What the server says to a draft; the text is empty while something is wrong. */
export interface DraftAnswer { layout: ChartLayout; problems: Problem[]; text: string }

export type Entry = [number: number, time: number, kind: string, text: string];
export interface Standing {
  state: string;
  run: 'stopped' | 'running' | 'paused' | 'done';
  status: string;
  edits: number;
  source: string;
  variables: Record<string, string>;
}
export interface MachineRow { id: string; state: string; run: string; status: string }
/** Where machines are stored: properties of storage services, folders that were granted and files in them. */
export interface Places { stored: string[]; folders: string[]; files: string[] }
