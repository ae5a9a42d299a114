import type { System } from './system';
import type { Component, Connector } from './types';

/** Which part of the system is shown; empty texts are no limit. Other than a filter of the lists it holds for the diagram, too. */
export interface Scope {
  host: string; manager: string; type: string;
  /** Only what connectors lead to from this component, in so many steps. */
  near: string; steps: number;
  /** Only what is in this composite. */
  inside: string;
}

export const WHOLE: Scope = { host: '', manager: '', type: '', near: '', steps: 1, inside: '' };

export const isWhole = ({ host, manager, type, near, inside }: Scope): boolean => !(host || manager || type || near || inside);

type Parts = Pick<System, 'managers' | 'components' | 'connectors'>;

/** The components of a scope; null for all. */
export function scoped(scope: Scope, system: Parts): ReadonlySet<string> | null {
  if (isWhole(scope)) return null;
  const near = scope.near ? within(scope.near, scope.steps, system.connectors.values()) : null;
  return new Set([...system.components.values()].filter((one) =>
    (!scope.host || system.managers.get(one.manager)?.host === scope.host) &&
    (!scope.manager || one.manager === scope.manager) &&
    (!scope.type || one.type === scope.type) &&
    (!scope.inside || isInside(one, scope.inside, system)) &&
    (!near || near.has(one.id) || one.members.some((member) => near.has(member)))).map(({ id }) => id));
}

/** The system without what is out of the scope; connectors stay where both ends do. */
export function narrowed(system: System, shown: ReadonlySet<string> | null): System {
  if (!shown) return system;
  return {
    ...system,
    components: new Map([...system.components].filter(([id]) => shown.has(id))),
    connectors: new Map([...system.connectors].filter(([, wire]) => shown.has(wire.source.component) && shown.has(wire.target.component))),
  };
}

/** Composites from the outermost one down to this one. */
export function wayTo(composite: string, components: System['components']): Component[] {
  const way: Component[] = [];
  for (let one = components.get(composite); one && !way.includes(one); one = components.get(one.composite)) way.unshift(one);
  return way;
}

function isInside(component: Component, composite: string, { components }: Parts): boolean {
  const seen = new Set<string>();
  for (let outer = component.composite; outer && !seen.has(outer); outer = components.get(outer)?.composite ?? '') {
    if (outer === composite) return true;
    seen.add(outer);
  }
  return false;
}

function within(from: string, steps: number, connectors: Iterable<Connector>): Set<string> {
  const neighbours = new Map<string, Set<string>>();
  const join = (one: string, other: string) => neighbours.set(one, (neighbours.get(one) ?? new Set()).add(other));
  for (const { source, target } of connectors) {
    join(source.component, target.component);
    join(target.component, source.component);
  }
  const found = new Set([from]);
  let edge = [from];
  for (let step = 0; step < steps && edge.length; step += 1) {
    edge = edge.flatMap((id) => [...(neighbours.get(id) ?? [])]).filter((id) => !found.has(id));
    for (const id of edge) found.add(id);
  }
  return found;
}
