import { useState } from 'react';

import { Modal } from '../../parts/Modal';
import { ChoiceField, TextField } from './fields';
import type { MachineRecord } from './types';
import { useMachineTexts } from './useMachine';

interface Props { machine: MachineRecord; from: string; onDraw: (to: string, on: string) => void; onClose: () => void }

/** Draws a transition by keys: where it leads, and on which event. */
export function WayDialog({ machine, from, onDraw, onClose }: Props) {
  const texts = useMachineTexts();
  const [to, setTo] = useState('');
  const [on, setOn] = useState('');
  return (
    <Modal title={texts.connectTitle(from)} className="machine-create" onClose={onClose}>
      <form method="dialog" onSubmit={(event) => { event.preventDefault(); onDraw(to, on.trim()); }}>
        <ChoiceField label={texts.fields.to} value={to} choices={[['', texts.fields.stays], ...machine.states.map((one) => [one.path, one.path] as const)]} onChange={setTo} />
        <TextField label={texts.fields.on} value={on} placeholder={texts.fields.onHint} onChange={setOn} />
        <footer>
          <button type="button" onClick={onClose}>{texts.diff.cancel}</button>
          <button type="submit" className="primary">{texts.connectGo}</button>
        </footer>
      </form>
    </Modal>
  );
}
