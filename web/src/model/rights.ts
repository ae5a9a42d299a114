import type { Manager, Rights } from './types';
import type { System } from './system';

/** What changes take: those of what is there an operator, to make and end things an administrator. */
export type Needed = 'operator' | 'administrator';

const RANKS: Record<Rights['role'], number> = { administrator: 3, operator: 2, viewer: 1, component: 1 };

/** Whether the user of the page may do at a manager what takes a role; at managers of the user's own everything. */
export const suffices = (rights: Rights | null | undefined, needed: Needed): boolean => !rights || RANKS[rights.role] >= RANKS[needed];

type Known = Pick<System, 'managers' | 'processes' | 'components' | 'connectors'>;

/** The managers of components, connectors, processes and managers, by their ids. */
function managersOf(system: Known, ids: readonly string[]): Manager[] {
  const owners = new Set<string>();
  for (const id of ids) {
    const wire = system.connectors.get(id);
    const ends = wire ? [wire.source.component, wire.target.component] : [id];
    for (const end of ends) owners.add(system.components.get(end)?.manager ?? system.processes.get(end)?.manager ?? end);
  }
  return [...owners].flatMap((id) => system.managers.get(id) ?? []);
}

const placeOf = (path: string): string => (path.startsWith('/') ? (path.split('/')[1] ?? '') : '');

/** The managers at the place of a property, component or service; none for what is named without a place, which is of this host. */
export const managersAt = (system: Known, target: string): string[] =>
  [...system.managers.keys()].filter((id) => placeOf(id) === placeOf(target));

/** A manager at which a plan may not be carried out: of the hosts that are named, or any of all where every one refuses. */
export function lackingFor(system: Known, needed: Needed, hosts: ReadonlySet<string>): Manager | undefined {
  const managers = [...system.managers.values()];
  const concerned = managers.filter(({ id, host }) => hosts.has(host) || hosts.has(placeOf(id)));
  const lacking = (concerned.length ? concerned : managers).filter(({ rights }) => !suffices(rights, needed));
  return concerned.length || lacking.length === managers.length ? lacking[0] : undefined;
}

/** The first manager of some things where the user may not do what takes a role. */
export const lackingAt = (system: Known, ids: readonly string[], needed: Needed): Manager | undefined =>
  managersOf(system, ids).find((manager) => !suffices(manager.rights, needed));

