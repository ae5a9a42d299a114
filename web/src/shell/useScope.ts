import { useMemo, useState } from 'react';

import { scoped, type Scope } from '../model/scope';
import type { System } from '../model/system';

/** The components that a scope leaves; the same object while they are the same ones, null for all. */
export function useScope({ managers, components, connectors }: System, scope: Scope): ReadonlySet<string> | null {
  const [keep] = useState(keptSet);
  return useMemo(() => keep(scoped(scope, { managers, components, connectors })), [keep, scope, managers, components, connectors]);
}

/** A function that returns the set of before while the next one has the same members. */
function keptSet(): (next: ReadonlySet<string> | null) => ReadonlySet<string> | null {
  let kept: ReadonlySet<string> | null = null;
  return (next) => {
    const before = kept;
    const isSame = next && before && next.size === before.size && [...next].every((id) => before.has(id));
    if (!isSame) kept = next;
    return kept;
  };
}
