import { useState, type SyntheticEvent } from 'react';

import type { System } from '../model/system';
import type { Component, Context } from '../model/types';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { Guests } from './Guests';
import { Link } from './Link';

/** Execution contexts of a component: kind, state, rate. */
export function Contexts({ system, component }: { system: System; component: Component }) {
  return <ul className="contexts">{component.contexts.map((context) => <ContextRow key={context.id} system={system} component={component} context={context} />)}</ul>;
}

function ContextRow({ system, component, context }: { system: System; component: Component; context: Context }) {
  const texts = useTexts();
  const { canChange, perform } = useEditor();
  const [typed, setTyped] = useState<string | null>(null);
  const rate = typed ?? String(context.rate_hz);
  const isChanged = typed !== null && Number(typed) !== context.rate_hz;
  const isGood = Number(rate) > 0;
  const apply = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!isChanged || !isGood) return;
    void perform([{ do: 'rate', component: component.id, context: context.id, rate_hz: Number(rate) }], texts.label.rate(component.name, rate))
      .then((isDone) => isDone && setTyped(null));
  };
  return (
    <li>
      <p>
        <strong>{context.id}</strong> {texts.contextKinds[context.kind]}, {context.is_running ? texts.inspector.running : texts.inspector.stopped}, {context.state}
      </p>
      {context.kind === 'PERIODIC' && (
        <form className="row" onSubmit={apply}>
          <label>{texts.inspector.rate} <input type="number" min="0" step="any" className={isChanged ? 'is-changed' : ''} aria-invalid={!isGood} disabled={!canChange}
            value={rate} onChange={(event) => setTyped(event.target.value)} /> {texts.inspector.hz}</label>
          {isChanged && <button type="submit" disabled={!canChange || !isGood}>{texts.inspector.set}</button>}
        </form>
      )}
      {context.missed > 0 && <p>{texts.manage.contexts.missed(context.missed)}</p>}
      {context.trouble && <p className="warning">⚠ {texts.manage.contexts.without(context.trouble)}</p>}
      {context.owner === component.id
        ? <Guests system={system} component={component} context={context} />
        : <p>{texts.manage.contexts.owner}: <Link id={context.owner} /></p>}
    </li>
  );
}
