import { useState, type SyntheticEvent } from 'react';

import type { System } from '../model/system';
import type { Action } from '../model/types';
import { Modal } from '../parts/Modal';
import { useEditor } from '../shell/contexts';
import type { Dialog } from '../shell/view';
import { useTexts } from '../texts';

/** A further set that is like one, without the parameters that are left out; or another name for one. */
export function SetDialog({ system, asked }: { system: System; asked: Extract<Dialog, { kind: 'set' }> }) {
  const texts = useTexts();
  const { sets, label } = texts.manage;
  const { open, perform, canChange } = useEditor();
  const component = system.components.get(asked.component);
  const [name, setName] = useState('');
  const [left, setLeft] = useState<readonly string[]>([]);
  const close = () => open(null);
  if (!component) return null;
  const { id, sets: known } = component;
  const values = known[asked.set] ?? {};
  const names = Object.keys(values);
  const isTaken = name in known;
  const isGood = name.trim() !== '' && !isTaken && left.length < names.length && canChange;
  const kept = Object.fromEntries(Object.entries(values).filter(([parameter]) => !left.includes(parameter)));
  const add: Action = left.length || asked.way === 'rename'
    ? { do: 'add_set', component: id, set: name.trim(), values: kept }
    : { do: 'add_set', component: id, set: name.trim(), source: asked.set };
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!isGood) return;
    close();
    // Removed first: a set that its author has given stays, and then nothing is changed.
    if (asked.way === 'rename') void perform([{ do: 'remove_set', component: id, set: asked.set }, add], label.renameSet(component.name, asked.set, name.trim()));
    else void perform([add], label.addSet(component.name, name.trim()));
  };
  return (
    <Modal title={sets.title[asked.way]} className="connect" onClose={close}>
      <form method="dialog" onSubmit={submit}>
        <p>{sets.like(asked.set)}</p>
        <label>{sets.name}
          {/* eslint-disable-next-line jsx-a11y/no-autofocus -- The dialog opens for this field. */}
          <input type="text" autoFocus value={name} aria-invalid={isTaken} onChange={(event) => setName(event.target.value)} />
        </label>
        {isTaken && <p className="error">{sets.taken}</p>}
        {asked.way === 'copy' && (
          <fieldset className="far-ports">
            <legend>{sets.which}</legend>
            <div className="options">
              {names.map((parameter) => (
                <label key={parameter}>
                  <input type="checkbox" checked={!left.includes(parameter)}
                    onChange={(event) => setLeft(event.target.checked ? left.filter((one) => one !== parameter) : [...left, parameter])} />
                  {parameter} <span className="note">{values[parameter]}</span>
                </label>
              ))}
            </div>
          </fieldset>
        )}
        <footer>
          <button type="button" onClick={close}>{texts.plan.cancel}</button>
          <button type="submit" className="primary" disabled={!isGood}>{sets.go}</button>
        </footer>
      </form>
    </Modal>
  );
}
