import { useEffect, useRef } from 'react';

import type { System } from '../model/system';
import type { View } from '../shell/view';
import { useTexts } from '../texts';
import { ComponentInspector } from './ComponentInspector';
import { ConnectorInspector } from './ConnectorInspector';
import { ManagerInspector } from './ManagerInspector';
import { Overview } from './Overview';
import { RightsGate, RightsNote } from './RightsGate';
import { SelectionInspector } from './SelectionInspector';

/** What is selected, and what can be done with it; an overview when nothing is. */
export function Inspector({ system, view, focusCount }: { system: System; view: View; focusCount: number }) {
  const texts = useTexts();
  const ref = useRef<HTMLElement>(null);
  useEffect(() => {
    if (focusCount) ref.current?.focus();
  }, [focusCount]);
  return (
    <section className="panel inspector" aria-label={texts.inspector.title} tabIndex={-1} ref={ref}>
      <RightsGate system={system} ids={view.selection}>
        <RightsNote system={system} ids={view.selection} />
        <Shown system={system} view={view} />
      </RightsGate>
    </section>
  );
}

function Shown({ system, view }: { system: System; view: View }) {
  const known = view.selection.filter((id) => system.components.has(id) || system.connectors.has(id) || system.processes.has(id) || system.managers.has(id));
  const [id] = known;
  if (id === undefined) return <Overview system={system} />;
  if (known.length > 1) return <SelectionInspector system={system} ids={known} />;
  const component = system.components.get(id);
  if (component) return <ComponentInspector key={id} system={system} component={component} drafts={view.drafts} />;
  const wire = system.connectors.get(id);
  if (wire) return <ConnectorInspector key={id} system={system} wire={wire} />;
  return <ManagerInspector key={id} system={system} id={id} />;
}
