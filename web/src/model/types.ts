/** Records of the contract between the page and the server. Field names are those on the wire. */

export type Look =
  | 'active' | 'inactive' | 'error' | 'created' | 'unknown' | 'zombie' | 'stuck' | 'unreachable' | 'restarting';

export const LOOKS: readonly Look[] = [
  'error', 'zombie', 'stuck', 'unreachable', 'restarting', 'unknown', 'active', 'inactive', 'created',
];

/** Looks that need somebody's attention. */
export const TROUBLED: ReadonlySet<Look> = new Set<Look>(['error', 'zombie', 'stuck', 'unreachable']);

export type Direction = 'in' | 'out' | 'service';

/** What the user of the page is at a manager that lets users in by their certificates. */
export interface Rights { name: string; role: 'administrator' | 'operator' | 'viewer' | 'component' }

export interface Manager {
  id: string; name: string; host: string; pid: number; version: string;
  state: 'up' | 'gone'; why: string;
  /** Null at managers of the user's own, where all may be done. */
  rights: Rights | null;
}

export interface Process {
  id: string; name: string; manager: string; pid: number;
  state: 'up' | 'starting' | 'stopped' | 'silent' | 'lost'; why: string; is_slave: boolean;
}

export interface Context {
  id: string; kind: 'PERIODIC' | 'EVENT_DRIVEN' | 'OTHER'; rate_hz: number; is_running: boolean;
  state: string; owner: string;
  /** Components that it drives besides its owner. */
  participants: string[];
  /** Periods at which nothing was done. */
  missed: number;
  /** Settings that the system refused; empty for none. */
  trouble: string;
}

export interface Interface { instance: string; type: string; polarity: 'Provided' | 'Required' }

export interface Port { name: string; direction: Direction; type: string; interfaces: Interface[] }

export interface Component {
  id: string; name: string; type: string; type_id: string; manager: string; process: string;
  state: 'Active' | 'Inactive' | 'Error' | 'Created' | 'Unknown';
  look: Look; word: string; remark: string; since: number; description: string;
  composite: string; members: string[]; is_composite: boolean;
  contexts: Context[]; ports: Port[];
  active_set: string; sets: Record<string, Record<string, string>>;
  widgets: Record<string, string>; constraints: Record<string, string>;
  properties: Record<string, string>;
}

export interface PortEnd { component: string; port: string }

export interface Connector {
  id: string; name: string; source: PortEnd; target: PortEnd;
  properties: Record<string, string>; trouble: string;
}

export interface TreeEvent { time: number; kind: string; path: string; subject: string; event: string; detail: string }

export interface Records {
  managers: Manager[]; processes: Process[]; components: Component[]; connectors: Connector[];
}

export interface Picture extends Records { revision: number; since: number; host: string; version: string; read_only: boolean; jobs: Job[] }

export interface Change extends Records {
  revision: number; time: number;
  gone: { managers: string[]; processes: string[]; components: string[]; connectors: string[] };
  events: TreeEvent[];
}

export interface Rates {
  connectors: Record<string, { hz: number | null; written: number | null }>;
  components: Record<string, { hz: number | null; load: number | null }>;
}

export interface Notice { level: 'error' | 'warning' | 'info'; text: string }

/** A command line that goes on for some time; `status` is null while it runs, `count` the number of rows it has told. */
export interface Job { id: string; kind: string; text: string; command: string; status: number | null; error: string; count: number }

/** One of the JSON objects that a job tells. */
export type JobRow = Record<string, unknown>;

/** News of a job; `first` is the number of the first of its new rows. */
export interface JobNews extends Job { first?: number; rows?: JobRow[] }

export type BoxKind = 'component' | 'process' | 'manager' | 'composite';

/** The side of a box, and how far along it: from the top, or from the left at the sides above and below. */
export type Side = 'left' | 'right' | 'top' | 'bottom';
export interface PortPlace { side: Side; y: number; x?: number }

export interface Box {
  x: number; y: number; width: number; height: number; parent: string | null; kind: BoxKind; is_folded: boolean;
  /** Where wires end, below the top of the box; a folded frame takes all of a side at one place, named "left" or "right". */
  ports: Record<string, PortPlace>;
}

export type Point = [number, number];

export interface Layout {
  revision: number; width: number; height: number;
  boxes: Record<string, Box>; paths: Record<string, Point[]>;
  /** Corners that a profile states of connectors; they lie between the two ends, wherever these stand. */
  bends?: Record<string, Point[]>;
}

export type Action =
  | { do: 'connect'; source: string; target: string; id?: string; name?: string; properties?: Record<string, string> }
  | { do: 'disconnect'; connector: string }
  | { do: 'activate' | 'deactivate' | 'reset'; component: string; context?: string }
  | { do: 'configure'; component: string; set: string; values: Record<string, string>; expect?: Record<string, string> }
  | { do: 'activate_set'; component: string; set: string }
  | { do: 'rate'; component: string; context: string; rate_hz: number }
  | { do: 'load'; manager: string; path: string; init?: string }
  | { do: 'create'; manager: string; create: string }
  | { do: 'delete'; component: string }
  | { do: 'inject'; port: string; value: string }
  | { do: 'add_set'; component: string; set: string; source?: string; values?: Record<string, string> }
  | { do: 'remove_set'; component: string; set: string }
  | { do: 'attach' | 'detach'; component: string; context: string; participant: string }
  | { do: 'compose'; process: string; name: string; type: string; members: string[]; ports: string[]; options?: string }
  | { do: 'dissolve'; component: string }
  | { do: 'add_member' | 'remove_member'; component: string; member: string; ports: string[] }
  | { do: 'forget_zombies' }
  | { do: 'unload'; manager: string; path: string; init: string }
  | { do: 'fork' | 'restart_manager'; manager: string }
  | { do: 'end_slave'; process: string }
  | { do: 'start_manager'; name: string; host?: string }
  | { do: 'stop_manager'; manager: string; keep: boolean }
  | { do: 'save'; file: string; replace?: boolean }
  | { do: 'order'; file: string; order: string; steps: string[]; expect?: string[] }
  | { do: 'set'; target: string; value: string; expect?: string }
  | MachineAction;

/** What is done with a state machine; `machine` is the path of its service. */
export type MachineAction =
  | { do: 'edit_machine'; machine: string; text: string; edits: number; goto: string; before: string }
  | { do: 'run_machine'; machine: string; word: string }
  | { do: 'send_event'; machine: string; name: string }
  | { do: 'set_variable'; machine: string; name: string; value: string }
  | { do: 'keep_machine'; machine: string; target: string }
  | { do: 'store_state'; target: string; text: string }
  | { do: 'save_machine'; machine: string; file: string; replace: boolean; at: string }
  | { do: 'create_machine'; manager: string; name: string; service: string }
  | { do: 'activate_machine'; manager: string; name: string };

export interface Step { text: string; command: string; ok: boolean | null; error: string }

export interface Done { steps: Step[]; undo: Action[] | null; undo_reason: string }

/** A change that was asked of the server; `old` and `new` are null where there is no value, or none that is known. */
export interface AuditRecord {
  id: number; time: number; page: string; by: string; text: string; command: string;
  old: string | null; new: string | null; error: string; count: number;
}

export interface Connectable { path: string; type: string; why: string }

/** What a manager can make: types of modules that are loaded or found, and modules that it could load. */
export interface Offers {
  types: { name: string; id: string; module: string }[];
  modules: { path: string; problem: string }[];
  loaded: { path: string; init: string }[];
}

/** Folders that the user has granted, and the system profiles in them. */
export interface Files { folders: string[]; files: string[] }

export const EXPORT_FORMS = ['svg', 'dot', 'mermaid', 'text'] as const;
export type ExportForm = (typeof EXPORT_FORMS)[number];

/** The path of a port, as actions name it. */
export const portPath = (end: PortEnd): string => `${end.component}:${end.port}`;

/** The two parts of a port's path. Port names hold no colon; component paths may. */
export function portEnd(path: string): PortEnd {
  const at = path.lastIndexOf(':');
  return { component: path.slice(0, at), port: path.slice(at + 1) };
}
