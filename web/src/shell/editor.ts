import { useEffect, useMemo, useRef, type Dispatch } from 'react';

import type { Scope } from '../model/scope';
import type { System } from '../model/system';
import { portEnd, type Action, type Point } from '../model/types';
import type { Entry } from '../model/undo';
import type { Api } from '../server/api';
import type { Subscriptions } from '../server/subscriptions';
import type { Values } from '../server/values';
import type { Dialog, Filter, Panel, ViewEvent, ViewKind } from './view';

/** What the parts of the page ask for. */
export interface Editor {
  api: Api;
  subscriptions: Subscriptions;
  values: Values;
  /** False while the server is read-only or out of reach. */
  canWrite: boolean;
  /** False where the user may not change what lives either: see `RightsGate`. */
  canChange: boolean;
  /** False where the user may not make and end things either. */
  canMake: boolean;
  select: (ids: readonly string[]) => void;
  /** Selects one thing, unfolds what hides it and brings it to the middle. */
  reveal: (id: string) => void;
  toggleFold: (id: string) => void;
  place: (places: ReadonlyMap<string, { x: number; y: number }>) => void;
  arrange: () => void;
  /** Gives a box another size; only documents have sizes. */
  resize?: (id: string, size: { width: number; height: number }) => void;
  /** Leads a wire through other bend points; only documents have these. */
  bend?: (id: string, points: readonly Point[], isOver: boolean) => void;
  /** Goes to a room, and there to what `of` names. */
  show: (view: ViewKind, of?: string) => void;
  filter: (filter: Filter) => void;
  /** Shows a part of the system only, in the diagram and in lists. */
  narrow: (scope: Scope) => void;
  togglePanel: (panel: Panel) => void;
  open: (dialog: Dialog | null) => void;
  draft: (key: string, parameter: string, text: string | null) => void;
  undraft: (key: string) => void;
  perform: (actions: Action[], label: string) => Promise<boolean>;
  remember: (entry: Entry) => void;
}

export function useEditorValue(
  api: Api, subscriptions: Subscriptions, values: Values, canWrite: boolean, system: System, dispatch: Dispatch<ViewEvent>, perform: Editor['perform'],
  remember: Editor['remember'],
): Editor {
  const latest = useRef(system);
  useEffect(() => {
    latest.current = system;
  }, [system]);
  return useMemo<Editor>(() => ({
    api,
    subscriptions,
    values,
    canWrite,
    canChange: canWrite,
    canMake: canWrite,
    perform,
    remember,
    select: (ids) => dispatch({ kind: 'select', ids }),
    reveal: (path) => {
      const id = shownBy(path, latest.current);
      dispatch({ kind: 'reveal', id, ancestors: ancestors(id, latest.current) });
    },
    toggleFold: (id) => dispatch({ kind: 'fold', id }),
    place: (places) => dispatch({ kind: 'place', places }),
    arrange: () => dispatch({ kind: 'arrange' }),
    filter: (filter) => dispatch({ kind: 'filter', filter }),
    narrow: (scope) => dispatch({ kind: 'scope', scope }),
    show: (view, of = '') => dispatch({ kind: 'show', view, of }),
    togglePanel: (panel) => dispatch({ kind: 'panel', panel }),
    open: (dialog) => dispatch({ kind: 'dialog', dialog }),
    draft: (key, parameter, text) => dispatch({ kind: 'draft', key, parameter, text }),
    undraft: (key) => dispatch({ kind: 'undraft', key }),
  }), [api, subscriptions, values, canWrite, dispatch, perform, remember]);
}

/** Events name ports, too: what is shown then is the component of the port. */
function shownBy(path: string, system: Pick<System, 'components'>): string {
  const { component } = portEnd(path);
  return !system.components.has(path) && system.components.has(component) ? component : path;
}

/** The boxes round a component: composites, process and manager. */
export function ancestors(id: string, system: Pick<System, 'components' | 'processes'>): string[] {
  const found: string[] = [];
  const component = system.components.get(id);
  for (let outer = component?.composite; outer; outer = system.components.get(outer)?.composite) found.push(outer);
  if (component) found.push(component.process, component.manager);
  const manager = system.processes.get(id)?.manager;
  return manager && manager !== id ? [...found, manager] : found;
}
