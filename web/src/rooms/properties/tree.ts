import { matches } from '../../model/search';
import type { System } from '../../model/system';

/** A service, component, manager or host that has properties. */
export interface Owner { target: string; note: string; kind: 'service' | 'component' | 'manager' | 'host' }

export interface Service { target: string; types: string[] }

/** One visible row of the tree. */
export interface Row { target: string; name: string; note: string; level: number; isBranch: boolean; isOpen: boolean }

/** All that has properties: services first, then what the diagram shows. */
export function ownersOf(services: readonly Service[], { components, managers }: Pick<System, 'components' | 'managers'>): Owner[] {
  return [
    ...services.map(({ target, types }): Owner => ({ target, note: types.join(' '), kind: 'service' })),
    ...[...components.values()].map((one): Owner => ({ target: one.id, note: one.type, kind: 'component' })),
    ...[...managers.values()].map((one): Owner => ({ target: one.id, note: '', kind: 'manager' })),
    { target: '/localhost', note: '', kind: 'host' },
  ];
}

/** The target of a property of an owner. */
export const targetOf = (owner: string, name: string): string => (name ? `${owner}.${name}` : owner);

/** The names directly below a name; a name that is only a part of others counts, too. */
export function below(names: readonly string[], above: string): string[] {
  const prefix = above ? `${above}.` : '';
  const first = (name: string): string => prefix + (name.slice(prefix.length).split('.')[0] ?? '');
  return [...new Set(names.filter((name) => name.startsWith(prefix)).map(first))];
}

/** The rows to show; with a text all whose target has it, without branches. */
export function rowsOf(owners: readonly Owner[], names: ReadonlyMap<string, readonly string[]>, open: ReadonlySet<string>, text: string): Row[] {
  if (text) return owners.flatMap((owner) => found(owner, names.get(owner.target) ?? [], text));
  return owners.flatMap((owner) => {
    const isOpen = open.has(owner.target);
    const row: Row = { target: owner.target, name: owner.target, note: owner.note, level: 1, isBranch: true, isOpen };
    return isOpen ? [row, ...rowsBelow(owner.target, names.get(owner.target) ?? [], '', open, 2)] : [row];
  });
}

function rowsBelow(owner: string, names: readonly string[], above: string, open: ReadonlySet<string>, level: number): Row[] {
  return below(names, above).flatMap((name) => {
    const target = targetOf(owner, name);
    const isBranch = names.some((one) => one.startsWith(`${name}.`));
    const isOpen = isBranch && open.has(target);
    const row: Row = { target, name: name.split('.').at(-1) ?? name, note: '', level, isBranch, isOpen };
    return isOpen ? [row, ...rowsBelow(owner, names, name, open, level + 1)] : [row];
  });
}

function found(owner: Owner, names: readonly string[], text: string): Row[] {
  const row = (target: string, note: string): Row => ({ target, name: target, note, level: 1, isBranch: false, isOpen: false });
  const inside = names.filter((name) => matches(targetOf(owner.target, name), text)).map((name) => row(targetOf(owner.target, name), ''));
  return matches(`${owner.target} ${owner.note}`, text) ? [row(owner.target, owner.note), ...inside] : inside;
}
