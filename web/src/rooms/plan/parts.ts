import type { System } from '../../model/system';
import type { Profile } from './types';

/** What is left out, by names as `--without` takes them: components, ids of connectors, `COMPONENT.SET`. */
export type LeftOut = ReadonlySet<string>;

export const isHidden = (set: string): boolean => set.startsWith('__');
export const setName = (component: string, set: string): string => `${component}.${set}`;
export const setsOf = (component: Profile['components'][number]): string[] => component.sets.filter((set) => !isHidden(set));

/** The same with some names put in, or taken out. */
export function toggled(left: LeftOut, names: readonly string[], isLeft: boolean): LeftOut {
  const next = new Set(left);
  for (const name of names) if (isLeft) next.add(name); else next.delete(name);
  return next;
}

/** What is asked for: nothing twice. A component takes its connectors and sets along; where all sets are left out, so are the hidden ones. */
export function withoutParts(profile: Profile, left: LeftOut): string[] {
  const gone = new Set(profile.components.map(({ name }) => name).filter((name) => left.has(name)));
  const settings = profile.components.filter(({ name }) => !gone.has(name)).flatMap((component) => {
    const names = setsOf(component).map((set) => setName(component.name, set));
    const out = names.filter((name) => left.has(name));
    return out.length > 0 && out.length === names.length ? [setName(component.name, '*')] : out;
  });
  const wires = profile.connectors.filter(({ id, ends }) => left.has(id) && !ends.some((end) => gone.has(end))).map(({ id }) => id);
  return [...gone, ...wires, ...settings];
}

/** Where components can go, as `--place` takes it: managers and slaves that live. */
export function placesIn({ managers, processes }: Pick<System, 'managers' | 'processes'>): string[] {
  const slaves = [...processes.values()].filter((one) => one.is_slave).map(({ id }) => id);
  return [...managers.keys(), ...slaves].sort();
}
