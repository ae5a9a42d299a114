import { WHOLE, type Scope } from '../model/scope';
import type { Look, PortEnd } from '../model/types';
import type { Address } from './address';
import type { RoomKind } from './rooms';

export type Panel = 'tree' | 'inspector' | 'events';
export type ViewKind = 'diagram' | 'table' | RoomKind;
/** What the tree and the tables show of all that there is. */
export interface Filter { text: string; look: Look | 'all' | 'troubled'; kind: KindFilter }

export const KIND_FILTERS = ['all', 'manager', 'slave', 'composite', 'component'] as const;
export type KindFilter = (typeof KIND_FILTERS)[number];

export type Dialog =
  | { kind: 'palette' | 'keys' | 'export' | 'start' }
  | { kind: 'set'; component: string; set: string; way: 'copy' | 'rename' }
  | { kind: 'compose'; members: readonly string[] }
  | { kind: 'modules'; manager: string }
  | { kind: 'create'; manager: string; slave: string }
  | { kind: 'load'; manager: string }
  | { kind: 'connect'; from: PortEnd | null; to: PortEnd | null; component: string };

/** What this page shows and how; nothing of it is known to the server. */
export interface View {
  kind: ViewKind;
  /** What the room is about: a file, a path, a name; empty for its first page. */
  of: string;
  selection: readonly string[];
  filter: Filter;
  scope: Scope;
  folded: ReadonlySet<string>;
  placed: ReadonlyMap<string, { x: number; y: number }>;
  panels: Readonly<Record<Panel, boolean>>;
  dialog: Dialog | null;
  /** What to bring to the middle of the window; the count tells two requests for the same apart. */
  centre: { id: string; count: number } | null;
  /** Values that were typed and not applied, by component and set, then by parameter. */
  drafts: ReadonlyMap<string, Readonly<Record<string, string>>>;
}

export type ViewEvent =
  | { kind: 'show'; view: ViewKind; of: string }
  | { kind: 'select'; ids: readonly string[] }
  | { kind: 'reveal'; id: string; ancestors: readonly string[] }
  | { kind: 'fold'; id: string }
  | { kind: 'place'; places: ReadonlyMap<string, { x: number; y: number }> }
  | { kind: 'arrange' }
  | { kind: 'panel'; panel: Panel }
  | { kind: 'dialog'; dialog: Dialog | null }
  | { kind: 'draft'; key: string; parameter: string; text: string | null }
  | { kind: 'undraft'; key: string }
  | { kind: 'filter'; filter: Filter }
  | { kind: 'scope'; scope: Scope }
  | { kind: 'address'; address: Address };

/** At 1024 pixels the strip of events would leave the diagram too little room. */
const hasRoom = typeof innerHeight === 'undefined' || innerHeight > 780;

export const FIRST_VIEW: View = {
  kind: 'diagram', of: '', selection: [], filter: { text: '', look: 'all', kind: 'all' }, scope: WHOLE, folded: new Set(), placed: new Map(),
  panels: { tree: true, inspector: true, events: hasRoom }, dialog: null, centre: null, drafts: new Map(),
};

export const draftKey = (component: string, set: string): string => `${component}\n${set}`;

export function reduceView(view: View, event: ViewEvent): View {
  switch (event.kind) {
    case 'show':
      return { ...view, kind: event.view, of: event.of };
    case 'select':
      return sameIds(view.selection, event.ids) ? view : { ...view, selection: event.ids };
    case 'reveal': {
      const folded = new Set([...view.folded].filter((id) => !event.ancestors.includes(id)));
      return { ...view, selection: [event.id], folded, centre: { id: event.id, count: (view.centre?.count ?? 0) + 1 } };
    }
    case 'filter':
      return { ...view, filter: event.filter };
    case 'scope':
      return { ...view, scope: event.scope };
    case 'address':
      return arrived(view, event.address);
    case 'fold': {
      const folded = new Set(view.folded);
      if (!folded.delete(event.id)) folded.add(event.id);
      return { ...view, folded };
    }
    case 'place':
      return { ...view, placed: new Map([...view.placed, ...event.places]) };
    case 'arrange':
      return { ...view, placed: new Map() };
    case 'panel':
      return { ...view, panels: { ...view.panels, [event.panel]: !view.panels[event.panel] } };
    case 'dialog':
      return { ...view, dialog: event.dialog };
    case 'draft':
      return { ...view, drafts: drafted(view.drafts, event.key, event.parameter, event.text) };
    case 'undraft': {
      const drafts = new Map(view.drafts);
      drafts.delete(event.key);
      return { ...view, drafts };
    }
  }
}

/** The view that an address tells; what it names is brought to the middle. */
export function arrived(view: View, address: Address): View {
  const [id] = address.selection;
  const centre = id === undefined ? view.centre : { id, count: (view.centre?.count ?? 0) + 1 };
  return { ...view, ...address, folded: new Set(), centre };
}

function drafted(drafts: View['drafts'], key: string, parameter: string, text: string | null): View['drafts'] {
  const values = Object.entries(drafts.get(key) ?? {}).filter(([name]) => name !== parameter);
  if (text !== null) values.push([parameter, text]);
  const after = new Map(drafts);
  if (values.length) after.set(key, Object.fromEntries(values));
  else after.delete(key);
  return after;
}

const sameIds = (one: readonly string[], other: readonly string[]): boolean =>
  one.length === other.length && one.every((id, index) => id === other[index]);
