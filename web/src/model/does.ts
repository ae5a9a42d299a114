import { shortName, wiresAt } from './ports';
import type { System } from './system';
import { portPath, type Action, type Component, type Connector } from './types';

/** A request of the user: its actions and the words for it. */
export interface Request { actions: Action[]; label: string }

export type Verb = 'activate' | 'deactivate' | 'reset' | 'delete';

/** Whether a verb makes sense for a component as it is now. */
export function allows(component: Component, verb: Verb): boolean {
  if (verb === 'delete') return true;
  if (component.look === 'zombie' || component.look === 'unreachable') return false;
  return component.state === { activate: 'Inactive', deactivate: 'Active', reset: 'Error' }[verb];
}

/** The verb for all those of some components that it fits; no actions when it fits none. */
export function verbActions(components: readonly Component[], verb: Verb): Action[] {
  return components.filter((component) => allows(component, verb)).map(({ id }) => ({ do: verb, component: id }));
}

export const disconnectActions = (wires: readonly Connector[]): Action[] =>
  wires.map((wire) => ({ do: 'disconnect', connector: wire.id }));

/** What Delete does to a selection: selected connectors are disconnected, selected components end. */
export function removeActions(ids: readonly string[], system: Pick<System, 'components' | 'connectors'>): Action[] {
  const wires = ids.flatMap((id) => system.connectors.get(id) ?? []);
  const components = ids.flatMap((id) => system.components.get(id) ?? []);
  return [...disconnectActions(wires), ...verbActions(components, 'delete')];
}

/** The ends of a connector in words: `Camera0:image`. */
export const endText = ({ component, port }: Connector['source']): string => `${shortName(component)}:${port}`;

/** A wire's name for people. */
export const wireText = (wire: Connector): string => `${endText(wire.source)} → ${endText(wire.target)}`;

/** The far ends of a port's wires. */
export function farEnds(system: Pick<System, 'connectors'>, component: string, port: string): { wire: Connector; far: Connector['source'] }[] {
  const own = portPath({ component, port });
  return wiresAt(system.connectors.values(), component, port).map((wire) => ({
    wire, far: portPath(wire.source) === own ? wire.target : wire.source,
  }));
}

/** The zombies that can be forgotten: those that are to be made again are none. */
export const zombies = ({ components }: Pick<System, 'components'>): Component[] => [...components.values()].filter((one) => one.look === 'zombie');

/** Actions that end something that runs: they are asked first. */
const ENDING: ReadonlySet<Action['do']> = new Set<Action['do']>(['delete', 'forget_zombies', 'end_slave', 'restart_manager', 'stop_manager']);

export const ends = (actions: readonly Action[]): boolean => actions.some((action) => ENDING.has(action.do));
