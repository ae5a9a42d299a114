import { useState, type SyntheticEvent } from 'react';

import { ParameterField } from '../../panels/ParameterField';
import { Icon } from '../../parts/icons';
import type { DocumentComponent } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

/** Configuration sets of a component of a document. What is typed is taken by Apply. */
export function SetEditor({ component, isFixed, document }: { component: DocumentComponent; isFixed: boolean; document: OpenDocument }) {
  const texts = useDocumentTexts();
  const names = Object.keys(component.sets);
  const [chosen, setChosen] = useState(component.active_set);
  const [typed, setTyped] = useState<Readonly<Record<string, string>>>({});
  const [fresh, setFresh] = useState('');
  const [added, setAdded] = useState('');
  const set = names.includes(chosen) ? chosen : names[0] ?? '';
  const values = component.sets[set] ?? {};
  const missing = Object.entries(component.declared).filter(([name]) => !(name in values));
  const { id } = component;
  const choose = (name: string) => { setChosen(name); setTyped({}); };
  const apply = (event: SyntheticEvent) => {
    event.preventDefault();
    void document.edit({ do: 'configure', component: id, set, values: typed }).then((after) => after && setTyped({}));
  };
  const addSet = (source: string) => void document.edit({ do: 'add_set', component: id, set: fresh, source }).then((after) => { if (after) { choose(fresh); setFresh(''); } });
  const addParameter = (event: SyntheticEvent) => {
    event.preventDefault();
    void document.edit({ do: 'configure', component: id, set, values: { [added]: component.declared[added] ?? '' } }).then((after) => after && setAdded(''));
  };
  return (
    <div className="configuration">
      {names.length === 0 && <p className="empty">{texts.noSets}</p>}
      {names.length > 0 && (
        <div className="row">
          <label className="set">{texts.set}
            <select value={set} onChange={(event) => choose(event.target.value)}>{names.map((name) => <option key={name} value={name}>{name}{name === component.active_set ? ` (${texts.active})` : ''}</option>)}</select>
          </label>
          <button type="button" disabled={isFixed || set === component.active_set} onClick={() => void document.edit({ do: 'activate_set', component: id, set })}>{texts.activate}</button>
          <button type="button" className="quiet" disabled={isFixed || set === component.active_set} onClick={() => void document.edit({ do: 'remove_set', component: id, set })}>{texts.removeSet}</button>
        </div>
      )}
      <form onSubmit={apply} className="configuration">
        {Object.entries(values).map(([name, value]) => (
          <div key={`${set} ${name}`} className="row">
            <div className="grow">
              <ParameterField name={name} live={value} typed={typed[name] ?? null} widget={component.widgets[name] ?? 'text'} constraint={component.constraints[name] ?? ''} isDisabled={isFixed}
                onChange={(text) => setTyped((before) => Object.fromEntries(Object.entries({ ...before, [name]: text }).filter(([key, one]) => one !== values[key])))} />
            </div>
            <button type="button" className="quiet" disabled={isFixed} aria-label={texts.removeParameter(name)} title={texts.removeParameter(name)} onClick={() => void document.edit({ do: 'configure', component: id, set, values: { [name]: null } })}><Icon name="close" /></button>
          </div>
        ))}
        {Object.keys(typed).length > 0 && <button type="submit" className="primary" disabled={isFixed}>{texts.apply} ({Object.keys(typed).length})</button>}
      </form>
      {set !== '' && (
        <form className="row" onSubmit={addParameter}>
          <input type="text" list={`declared ${id}`} aria-label={texts.parameter} placeholder={texts.parameter} value={added} disabled={isFixed} onChange={(event) => setAdded(event.target.value)} />
          <datalist id={`declared ${id}`}>{missing.map(([name]) => <option key={name} value={name} />)}</datalist>
          <button type="submit" disabled={isFixed || !added.trim() || added in values}>{texts.addParameter}</button>
        </form>
      )}
      <div className="row">
        <input type="text" aria-label={texts.setName} placeholder={texts.setName} value={fresh} disabled={isFixed} onChange={(event) => setFresh(event.target.value)} />
        <button type="button" disabled={isFixed || !fresh.trim()} onClick={() => addSet('')}>{texts.addSet}</button>
        {set !== '' && <button type="button" disabled={isFixed || !fresh.trim()} onClick={() => addSet(set)}>{texts.copySet}</button>}
      </div>
    </div>
  );
}
