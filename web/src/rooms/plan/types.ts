import type { Needed } from '../../model/rights';

/** Records of the room of plans. Field names are those on the wire. */

export const DEEDS = ['apply', 'restore', 'start', 'stop', 'take_down'] as const;
export type Deed = (typeof DEEDS)[number];

/** What each deed takes: see `model/rights.ts`. */
export const NEEDED: Readonly<Record<Deed, Needed>> = {
  apply: 'administrator', restore: 'administrator', start: 'operator', stop: 'operator', take_down: 'administrator',
};

/** Options without a value that each deed has, as its command has them. */
export const FLAGS: Readonly<Record<Deed, readonly Flag[]>> = {
  apply: ['replace', 'prune', 'rollback', 'stand-in'],
  restore: ['no-create', 'strict-path', 'stand-in'],
  start: [],
  stop: [],
  take_down: ['exit', 'uninstall'],
};
export type Flag = 'replace' | 'prune' | 'rollback' | 'stand-in' | 'no-create' | 'strict-path' | 'exit' | 'uninstall';

export const STATES = ['active', 'inactive', 'any'] as const;

/** What is asked for: no file means what lives now. */
export interface PlanRequest {
  do: Deed; file: string; flags: Flag[]; state?: (typeof STATES)[number];
  map?: Record<string, string>; place?: Record<string, string>; set?: Record<string, string>; prefix?: string; without?: string[];
}

export interface PlanStep {
  number: number; text: string; kind: string; layer: number; subject: string; cost: number; cost_from: string; change: string;
  required?: boolean; holds?: boolean; blocked?: string;
}

export interface PlanCheck { text: string; required: boolean; failure: string }

/** A plan as its command tells it, the record `plan` of docs/json.md, and what else the page shows of it. */
export interface Plan {
  steps: PlanStep[]; command: string; look: string; text: string; notes: string[];
  cost: number; checks?: PlanCheck[]; optimal?: boolean; gap?: number; kept?: { managers: number; components: number; connections: number };
}

/** What a system profile says. */
export interface Profile {
  components: { name: string; path: string; host: string; required: boolean; sets: string[] }[];
  connectors: { id: string; text: string; ends: string[] }[];
  variables: { name: string; default: string | null; description: string }[];
  orders: Record<string, string[]>;
}

export type Mark = '' | '+' | '-' | '~';

export interface Fact { mark: Mark; text: string; required: boolean; subject: string; wanted?: string; found?: string }

export interface ComparedBox { id: string; type: string; mark: Mark; x: number; y: number; width: number; height: number; ports: { name: string; side: 'left' | 'right'; y: number }[] }
export interface ComparedWire { id: string; mark: Mark; path: [number, number][] }

export interface Comparison {
  command: string; same: boolean; facts: Fact[];
  picture: { width: number; height: number; boxes: ComparedBox[]; wires: ComparedWire[] };
}
