import { useState, type SyntheticEvent } from 'react';

import { Modal } from '../parts/Modal';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** Starts a manager here, or on a host that `rthost list` knows. */
export function StartDialog() {
  const texts = useTexts();
  const { managers, label } = texts.manage;
  const { open, perform, canChange } = useEditor();
  const [name, setName] = useState('');
  const [host, setHost] = useState('');
  const close = () => open(null);
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (!canChange) return;
    close();
    void perform([{ do: 'start_manager', name: name.trim(), host: host.trim() }], label.start(name.trim() || host.trim() || 'manager'));
  };
  return (
    <Modal title={managers.title} className="connect" onClose={close}>
      <form method="dialog" onSubmit={submit}>
        <label>{managers.name}
          {/* eslint-disable-next-line jsx-a11y/no-autofocus -- The dialog opens for this field. */}
          <input type="text" autoFocus value={name} placeholder={managers.nameHint} onChange={(event) => setName(event.target.value)} />
        </label>
        <label>{managers.host} <input type="text" value={host} placeholder={managers.hostHint} onChange={(event) => setHost(event.target.value)} /></label>
        <footer>
          <button type="button" onClick={close}>{texts.plan.cancel}</button>
          <button type="submit" className="primary" disabled={!canChange}>{texts.plan.go}</button>
        </footer>
      </form>
    </Modal>
  );
}
