import { useState } from 'react';

import { misfit } from '../model/parameters';
import type { Component } from '../model/types';
import { useEditor } from '../shell/contexts';
import { draftKey, type View } from '../shell/view';
import { useTexts } from '../texts';
import { ParameterField } from './ParameterField';
import { SetTools } from './SetTools';

/** Configuration sets of a component. What is typed stays here, marked, until it is applied. */
export function Configuration({ component, drafts }: { component: Component; drafts: View['drafts'] }) {
  const texts = useTexts();
  const { canChange, perform, draft, undraft } = useEditor();
  const [chosen, setChosen] = useState<string | null>(null);
  const [showsHidden, setShowsHidden] = useState(false);
  const names = Object.keys(component.sets).filter((name) => showsHidden || !name.startsWith('__'));
  const hasHidden = Object.keys(component.sets).some((name) => name.startsWith('__'));
  const set = chosen !== null && names.includes(chosen) ? chosen : component.active_set;
  const live = component.sets[set] ?? {};
  const key = draftKey(component.id, set);
  const typed = Object.entries(drafts.get(key) ?? {}).filter(([name, value]) => name in live && live[name] !== value);
  const isBad = typed.some(([name, value]) => misfit(value, component.constraints[name] ?? '', component.widgets[name]));
  const apply = async () => {
    const isDone = await perform([{ do: 'configure', component: component.id, set, values: Object.fromEntries(typed) }], texts.label.configure(component.name));
    if (isDone) undraft(key);
  };
  return (
    <form className="configuration" onSubmit={(event) => { event.preventDefault(); void apply(); }}>
      <div className="row">
        <label className="set">{texts.inspector.setName}
          <select value={set} onChange={(event) => setChosen(event.target.value)}>
            {names.map((name) => <option key={name} value={name}>{name}{name === component.active_set ? ` (${texts.inspector.activeSet})` : ''}</option>)}
          </select>
        </label>
        {set !== component.active_set && !set.startsWith('__') && (
          <button type="button" disabled={!canChange} onClick={() => void perform([{ do: 'activate_set', component: component.id, set }], texts.label.activateSet(component.name, set))}>
            {texts.inspector.activateSet}
          </button>
        )}
      </div>
      {Object.keys(live).length === 0 && <p className="empty">{texts.inspector.noParameters}</p>}
      {Object.entries(live).map(([name, value]) => (
        <ParameterField key={`${set} ${name}`} name={name} live={value} typed={drafts.get(key)?.[name] ?? null} isDisabled={!canChange || set.startsWith('__')}
          widget={component.widgets[name] ?? 'text'} constraint={component.constraints[name] ?? ''}
          onChange={(text) => draft(key, name, text === value ? null : text)} />
      ))}
      {typed.length > 0 && (
        <div className="buttons sticky">
          <button type="submit" className="primary" disabled={!canChange || isBad}>{texts.inspector.apply} ({typed.length})</button>
          <button type="button" onClick={() => undraft(key)}>{texts.inspector.revert}</button>
        </div>
      )}
      {names.length > 0 && <SetTools component={component} set={set} />}
      {hasHidden && <label className="check"><input type="checkbox" checked={showsHidden} onChange={(event) => setShowsHidden(event.target.checked)} />{texts.inspector.hidden}</label>}
    </form>
  );
}
