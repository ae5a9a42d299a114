import { useState, type SyntheticEvent } from 'react';

import { shortName } from '../model/ports';
import type { System } from '../model/system';
import { Modal } from '../parts/Modal';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

const KINDS = ['PeriodicECSharedComposite', 'PeriodicStateSharedComposite', 'GroupingComposite'] as const;

/** Makes a composite of components: its name, its type, and which ports it shows. */
export function ComposeDialog({ system, members }: { system: System; members: readonly string[] }) {
  const texts = useTexts();
  const { composites, label } = texts.manage;
  const { open, perform, canChange } = useEditor();
  const parts = members.flatMap((id) => system.components.get(id) ?? []);
  const ports = parts.flatMap((one) => one.ports.map((port) => ({ path: `${one.id}:${port.name}`, text: `${one.name}:${port.name}`, note: texts.directions[port.direction] })));
  const [name, setName] = useState('');
  const [type, setType] = useState<(typeof KINDS)[number]>(KINDS[0]);
  const [rate, setRate] = useState('');
  const [shown, setShown] = useState<readonly string[]>(ports.filter(({ path }) => leadsOut(path, members, system)).map(({ path }) => path));
  const processes = new Set(parts.map((one) => one.process));
  const [process] = processes;
  const isGood = name.trim() !== '' && processes.size === 1 && canChange && (rate === '' || Number(rate) > 0);
  const close = () => open(null);
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!isGood || process === undefined) return;
    close();
    const options = rate ? { options: `exec_cxt.periodic.rate=${rate}` } : {};
    void perform([{ do: 'compose', process, name: name.trim(), type, members: [...members], ports: [...shown], ...options }], label.compose(name.trim()));
  };
  return (
    <Modal title={composites.title} className="connect" onClose={close}>
      <form method="dialog" onSubmit={submit}>
        <p>{texts.inspector.members}: {members.map(shortName).join(', ')}</p>
        {processes.size > 1 && <p className="error" role="alert">{composites.onePlace}</p>}
        <div className="grid">
          <label>{composites.name}
            {/* eslint-disable-next-line jsx-a11y/no-autofocus -- The dialog opens for this field. */}
            <input type="text" autoFocus value={name} onChange={(event) => setName(event.target.value)} />
          </label>
          <label>{composites.rate} <input type="number" min="0" step="any" placeholder="1000" value={rate} disabled={type === 'GroupingComposite'} onChange={(event) => setRate(event.target.value)} /></label>
        </div>
        <label>{composites.type}
          <select value={type} onChange={(event) => setType(event.target.value as typeof type)}>
            {KINDS.map((kind) => <option key={kind} value={kind}>{composites.types[kind]}</option>)}
          </select>
        </label>
        <fieldset className="far-ports">
          <legend>{composites.ports}</legend>
          <div className="options">
            {ports.map(({ path, text, note }) => (
              <label key={path} title={path}>
                <input type="checkbox" checked={shown.includes(path)} onChange={(event) => setShown(event.target.checked ? [...shown, path] : shown.filter((one) => one !== path))} />
                {text} <span className="note">{note}</span>
              </label>
            ))}
          </div>
        </fieldset>
        <footer>
          <button type="button" onClick={close}>{texts.plan.cancel}</button>
          <button type="submit" className="primary" disabled={!isGood}>{texts.create.go}</button>
        </footer>
      </form>
    </Modal>
  );
}

/** Whether a port is free, or connected with something that is no member: then the composite shows it, unless the user wishes otherwise. */
function leadsOut(path: string, members: readonly string[], system: System): boolean {
  const far = [...system.connectors.values()].flatMap(({ source, target }) => {
    if (`${source.component}:${source.port}` === path) return [target.component];
    return `${target.component}:${target.port}` === path ? [source.component] : [];
  });
  return far.length === 0 || far.some((id) => !members.includes(id));
}
