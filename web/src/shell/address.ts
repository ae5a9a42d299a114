import { LOOKS } from '../model/types';
import { isRoom } from './rooms';
import type { Filter, View, ViewKind } from './view';

/** What an address tells of a view: a link opens the same. The token is no part of it. */
export interface Address { kind: ViewKind; of: string; selection: readonly string[]; filter: Filter }

/** The fragment for a view; empty for the first one. */
export function fragmentOf({ kind, of, selection, filter }: Pick<View, keyof Address>): string {
  const fields = new URLSearchParams();
  if (kind !== 'diagram') fields.set('view', kind);
  if (of) fields.set('of', of);
  for (const id of selection) fields.append('select', id);
  if (filter.text) fields.set('filter', filter.text);
  if (filter.look !== 'all') fields.set('state', filter.look);
  // Slashes and colons may stand in a fragment, and paths are read more easily with them.
  return fields.toString().replaceAll('%2F', '/').replaceAll('%3A', ':');
}

/** The view that a fragment tells; what it does not know is left out. */
export function addressOf(fragment: string): Address {
  const fields = new URLSearchParams(fragment.replace(/^#/, ''));
  const look = fields.get('state') ?? 'all';
  const kind = fields.get('view') ?? '';
  return {
    kind: kind === 'table' || isRoom(kind) ? kind : 'diagram',
    of: fields.get('of') ?? '',
    selection: fields.getAll('select'),
    filter: { text: fields.get('filter') ?? '', look: isLookFilter(look) ? look : 'all' },
  };
}

const isLookFilter = (text: string): text is Filter['look'] => text === 'troubled' || (LOOKS as readonly string[]).includes(text);
