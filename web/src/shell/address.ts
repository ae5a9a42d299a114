import { WHOLE, type Scope } from '../model/scope';
import { LOOKS } from '../model/types';
import { isRoom } from './rooms';
import { KIND_FILTERS, type Filter, type KindFilter, type View, type ViewKind } from './view';

/** What an address tells of a view: a link opens the same. The token is no part of it. */
export interface Address { kind: ViewKind; of: string; selection: readonly string[]; filter: Filter; scope: Scope }

/** The fragment for a view; empty for the first one. */
export function fragmentOf({ kind, of, selection, filter, scope }: Pick<View, keyof Address>): string {
  const fields = new URLSearchParams();
  if (kind !== 'diagram') fields.set('view', kind);
  if (of) fields.set('of', of);
  for (const id of selection) fields.append('select', id);
  if (filter.text) fields.set('filter', filter.text);
  if (filter.look !== 'all') fields.set('state', filter.look);
  if (filter.kind !== 'all') fields.set('kind', filter.kind);
  for (const part of SCOPES) if (scope[part]) fields.set(part, scope[part]);
  if (scope.near) fields.set('steps', String(scope.steps));
  // Slashes and colons may stand in a fragment, and paths are read more easily with them.
  return fields.toString().replaceAll('%2F', '/').replaceAll('%3A', ':');
}

/** The view that a fragment tells; what it does not know is left out. */
export function addressOf(fragment: string): Address {
  const fields = new URLSearchParams(fragment.replace(/^#/, ''));
  const look = fields.get('state') ?? 'all';
  const kind = fields.get('view') ?? '';
  const only = fields.get('kind') ?? 'all';
  const steps = Number(fields.get('steps') ?? '1');
  return {
    kind: kind === 'table' || isRoom(kind) ? kind : 'diagram',
    of: fields.get('of') ?? '',
    selection: fields.getAll('select'),
    filter: { text: fields.get('filter') ?? '', look: isLookFilter(look) ? look : 'all', kind: isKindFilter(only) ? only : 'all' },
    scope: {
      ...WHOLE, ...Object.fromEntries(SCOPES.map((part) => [part, fields.get(part) ?? ''])),
      steps: Number.isInteger(steps) && steps > 0 ? steps : 1,
    },
  };
}

/** Fields of an address that narrow what is shown. */
const SCOPES = ['host', 'manager', 'type', 'near', 'inside'] as const;

const isKindFilter = (text: string): text is KindFilter => (KIND_FILTERS as readonly string[]).includes(text);

const isLookFilter = (text: string): text is Filter['look'] => text === 'troubled' || (LOOKS as readonly string[]).includes(text);
