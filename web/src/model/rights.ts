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

/** The first manager of some things where the user may not do what takes a role. */
export const lackingAt = (system: Known, ids: readonly string[], needed: Needed): Manager | undefined =>
  managersOf(system, ids).find((manager) => !suffices(manager.rights, needed));

