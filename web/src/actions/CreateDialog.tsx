import { useId, useState, type SyntheticEvent } from 'react';

import { badLine } from '../model/connecting';
import { createString, typeKey, type Creation } from '../model/creating';
import { shortName } from '../model/ports';
import { matches } from '../model/search';
import type { System } from '../model/system';
import { Modal } from '../parts/Modal';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { useOffers } from './useOffers';

/** Creates a component: its type, and where the user wishes so its name, its slave and its parameters. */
export function CreateDialog({ system, manager, slave }: { system: System; manager: string; slave: string }) {
  const texts = useTexts();
  const words = texts.create;
  const { open, perform, canChange } = useEditor();
  const offers = useOffers(manager);
  const [wish, setWish] = useState<Creation>({ type: '', instance: '', slave, parameters: '' });
  const [filter, setFilter] = useState('');
  const id = useId();
  const set = (part: Partial<Creation>) => setWish({ ...wish, ...part });
  const wrongLine = badLine(wish.parameters);
  const create = createString(wish);
  const known = offers !== null && typeof offers !== 'string' ? offers.types : [];
  const shown = known.filter((type) => matches(`${type.name} ${type.id}`, filter));
  const slaves = [...system.processes.values()].filter((one) => one.manager === manager && one.is_slave);
  const close = () => open(null);

  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!wish.type || create === null || !canChange) return;
    close();
    void perform([{ do: 'create', manager, create }], texts.label.create(wish.instance.trim() || shortName(wish.type), shortName(manager)));
  };

  return (
    <Modal title={words.title(shortName(manager))} className="connect" onClose={close}>
      <form method="dialog" onSubmit={submit}>
        <fieldset className="far-ports">
          <legend>{texts.inspector.type}</legend>
          {/* eslint-disable-next-line jsx-a11y/no-autofocus -- The dialog opens for this choice. */}
          <input type="search" autoFocus aria-label={words.filter} placeholder={words.filter} value={filter} onChange={(event) => setFilter(event.target.value)} />
          {offers === null && <p className="empty">{words.asking}</p>}
          {typeof offers === 'string' && <p className="error">{offers}</p>}
          {offers !== null && typeof offers !== 'string' && shown.length === 0 && <p className="empty">{words.noType}</p>}
          <div className="options">
            {shown.map((type) => (
              <label key={type.id} title={type.module || type.id}>
                <input type="radio" name="type" checked={wish.type === typeKey(known, type)} onChange={() => set({ type: typeKey(known, type) })} />
                {type.name} <span className="note">{type.id}</span>
              </label>
            ))}
          </div>
        </fieldset>
        <div className="grid">
          <label>{words.instance} <input type="text" value={wish.instance} placeholder={words.instanceHint} onChange={(event) => set({ instance: event.target.value })} /></label>
          <label>{words.slave} <input type="text" list={`${id}-slaves`} value={wish.slave} placeholder={words.slaveHint} onChange={(event) => set({ slave: event.target.value })} /></label>
        </div>
        <datalist id={`${id}-slaves`}>{slaves.map((one) => <option key={one.id} value={one.name} />)}</datalist>
        <label>{words.parameters}
          <textarea rows={3} value={wish.parameters} placeholder="conf.default.gain=2" aria-invalid={wrongLine !== null} onChange={(event) => set({ parameters: event.target.value })} />
        </label>
        {wrongLine !== null && <p className="error">{texts.connect.badLine(wrongLine)}</p>}
        <footer>
          <button type="button" onClick={close}>{texts.plan.cancel}</button>
          <button type="submit" className="primary" disabled={!wish.type || create === null || !canChange}>{words.go}</button>
        </footer>
      </form>
    </Modal>
  );
}
