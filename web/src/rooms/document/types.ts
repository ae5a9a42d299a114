import type { Component, Connector, Layout, Point } from '../../model/types';

/** What a list of open documents tells of one; `file` is empty until it was saved. */
export interface Heading { id: string; file: string; name: string; is_changed: boolean; revision: number }

/** What an earlier server kept of a document that was not saved. */
export interface Draft { id: string; file: string; name: string; time: string }

export interface ComponentType { file: string; id: string; name: string; category: string; vendor: string; version: string; description: string; ports: number }

/** A component of a profile; `origin` is the included file that it comes from, empty for the document itself. */
export interface DocumentComponent extends Component {
  origin: string; path: string; is_required: boolean; direction: string;
  /** The file of its component profile; empty where none is known. */
  source: string;
  /** Default values of the parameters that its type declares. */
  declared: Record<string, string>;
}

export interface DocumentConnector extends Connector {
  origin: string; data_type?: string; interface_type?: string; dataflow_type?: string; subscription_type?: string;
}

export type Severity = 'error' | 'warning' | 'note';

/** A finding of the static checks; `on` is the id of a component or connector, empty for the system. */
export interface Finding { severity: Severity; rule: string; text: string; allowed: string; on: string }

export interface Identity { vendor: string; name: string; version: string; abstract: string; comment: string; created: string; updated: string; log: string[] }

/** Everything about a document, as the server tells it after each edit. */
export interface Picture extends Heading {
  form: string; undo: string | null; redo: string | null; profile: Identity;
  variables: { name: string; value: string | null; description: string }[];
  includes: { file: string; prefix: string; values: Record<string, string> }[];
  groups: { id: string; members: string[] }[];
  components: DocumentComponent[]; connectors: DocumentConnector[];
  layout: Layout; places: Record<string, Standing>; bends: Record<string, Point[]>;
  findings: Finding[];
}

export interface Place { x: number; y: number }

export const DIRECTIONS = ['RIGHT', 'LEFT', 'DOWN', 'UP'] as const;
export type Direction = (typeof DIRECTIONS)[number];

/** Where a box stands by the profile, how large it is at least, and where its out ports point. */
export interface Standing extends Place { width?: number; height?: number; direction: Direction }

export type Edit =
  | { do: 'add'; type: string; name?: string; at?: Place }
  | { do: 'remove'; components: string[]; connectors: string[] }
  | { do: 'rename'; component: string; name: string }
  | { do: 'connect'; source: string; target: string; properties?: Record<string, string> }
  | { do: 'connector'; connector: string; properties: Record<string, string | null> }
  | { do: 'move'; places: Record<string, Place> }
  | { do: 'arrange' }
  | { do: 'resize'; component: string; width: number; height: number }
  | { do: 'turn'; component: string; direction: Direction }
  | { do: 'bend'; connector: string; points: Place[] }
  | { do: 'configure'; component: string; set: string; values: Record<string, string | null> }
  | { do: 'add_set'; component: string; set: string; source: string }
  | { do: 'remove_set' | 'activate_set'; component: string; set: string }
  | { do: 'require'; component: string; is_required: boolean }
  | { do: 'state'; component: string; key: string; value: string | null }
  | { do: 'identify'; vendor: string; name: string; version: string; abstract: string; comment: string; log: string[] };
