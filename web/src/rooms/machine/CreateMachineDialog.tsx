import { useState } from 'react';

import { suffices } from '../../model/rights';
import type { System } from '../../model/system';
import { RightsNote } from '../../panels/RightsGate';
import { Modal } from '../../parts/Modal';
import { useEditor } from '../../shell/contexts';
import { ChoiceField, TextField } from './fields';
import { useMachineTexts } from './useMachine';

interface Props { system: System; name: string; text: string; onCreated: (service: string) => void; onClose: () => void }

/** Makes a component that serves the machine, and puts what was drawn in force there. */
export function CreateMachineDialog({ system, name, text, onCreated, onClose }: Props) {
  const texts = useMachineTexts();
  const words = texts.creating;
  const { perform } = useEditor();
  const up = [...system.managers.values()].filter((one) => one.state === 'up');
  const managers = up.filter(({ rights }) => suffices(rights, 'administrator'));
  const [service, setService] = useState(name);
  const [instance, setInstance] = useState(name);
  const [manager, setManager] = useState(managers[0]?.id ?? '');
  const [isBusy, setBusy] = useState(false);
  const isReady = service.trim() !== '' && instance.trim() !== '' && manager !== '' && text !== '' && !isBusy;
  const create = async () => {
    setBusy(true);
    const host = system.managers.get(manager)?.host ?? '';
    const path = host && host !== system.host ? `/${host}/${service}` : service;
    const made = await perform([
      { do: 'create_machine', manager, name: instance, service },
      { do: 'activate_machine', manager, name: instance },
      { do: 'edit_machine', machine: path, text, edits: 0, goto: '', before: '' },
    ], texts.label.create(service));
    setBusy(false);
    if (made) onCreated(path);
  };
  return (
    <Modal title={words.title} className="machine-create" onClose={onClose}>
      <form method="dialog" onSubmit={(event) => { event.preventDefault(); if (isReady) void create(); }}>
        {up.length === 0 && <p className="error">{words.noManager}</p>}
        {managers.length === 0 && <RightsNote system={system} ids={up.map(({ id }) => id)} />}
        {text === '' && <p className="error">{words.wrong}</p>}
        <TextField label={words.service} value={service} onChange={setService} />
        <TextField label={words.instance} value={instance} onChange={setInstance} />
        <ChoiceField label={words.manager} value={manager} choices={managers.map((one) => [one.id, one.id] as const)} onChange={setManager} />
        <footer>
          <button type="button" onClick={onClose}>{texts.diff.cancel}</button>
          <button type="submit" className="primary" disabled={!isReady}>{words.go}</button>
        </footer>
      </form>
    </Modal>
  );
}
