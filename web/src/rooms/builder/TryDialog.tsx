import { useState, type SyntheticEvent } from 'react';

import { createString } from '../../model/creating';
import { shortName } from '../../model/ports';
import type { System } from '../../model/system';
import type { Action } from '../../model/types';
import { Modal } from '../../parts/Modal';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useTexts } from '../../texts';
import type { Preview } from './calls';
import { useBuilderTexts } from './fields';
import { freeName } from './form';

interface Props { system: System; module: NonNullable<Preview['module']>; isCurrent: boolean; onClose: () => void; onMade: (id: string) => void }

/** The path that a component will have: it stands beside its manager. */
const pathOf = (manager: string, instance: string): string => `${manager.slice(0, manager.lastIndexOf('/'))}/${instance}.rtc`;

/** Loads the module into a manager and creates one component of it. */
export function TryDialog({ system, module, isCurrent, onClose, onMade }: Props) {
  const texts = useBuilderTexts();
  const cancel = useTexts().plan.cancel;
  const { api, perform, canChange } = useEditor();
  const managers = [...system.managers.values()].filter((one) => one.state === 'up');
  const [manager, setManager] = useState(managers[0]?.id ?? '');
  const [slave, setSlave] = useState('');
  const names = [...system.components.values()].map((one) => one.name.replace(/\.rtc$/, ''));
  const [instance, setInstance] = useState(() => freeNumber(names, module.type));
  const [problem, setProblem] = useState('');
  const [isBusy, setBusy] = useState(false);

  const go = async () => {
    const { loaded } = await api.get<{ loaded: { path: string; init: string }[] }>(`/api/offers?manager=${encodeURIComponent(manager)}`);
    const before = loaded.find((one) => one.path === module.path);
    const create = createString({ type: module.type, instance, slave, parameters: '' }) ?? module.type;
    const actions: Action[] = [
      // A manager goes on with the code that it has loaded, until it forgets that.
      ...(before ? [{ do: 'unload' as const, manager, path: module.path, init: before.init }] : []),
      { do: 'load', manager, path: module.path, init: module.init },
      { do: 'create', manager, create },
    ];
    onClose();
    if (await perform(actions, texts.tryIt.label(module.type))) onMade(pathOf(manager, instance));
  };
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    setBusy(true);
    go().catch((error: unknown) => {
      setBusy(false);
      setProblem(sentence(error));
    });
  };
  return (
    <Modal title={texts.tryIt.title(module.type)} className="connect" onClose={onClose}>
      <form method="dialog" onSubmit={submit}>
        {managers.length === 0 && <p className="empty">{texts.tryIt.none}</p>}
        {!isCurrent && <p className="warning">⚠ {texts.tryIt.first}</p>}
        <label>{texts.tryIt.manager}
          <select value={manager} onChange={(event) => setManager(event.target.value)}>{managers.map((one) => <option key={one.id} value={one.id}>{shortName(one.id)} — {one.id}</option>)}</select>
        </label>
        <div className="grid">
          <label>{texts.tryIt.instance} <input type="text" value={instance} onChange={(event) => setInstance(event.target.value)} /></label>
          <label>{texts.tryIt.slave} <input type="text" value={slave} placeholder={texts.tryIt.slaveHint} onChange={(event) => setSlave(event.target.value)} /></label>
        </div>
        <p className="note">{texts.tryIt.warning} <code>{module.path}</code></p>
        {problem && <p className="error" role="alert">{problem}</p>}
        <footer>
          {isBusy && <span className="note" role="status">{texts.tryIt.asking}</span>}
          <button type="button" onClick={onClose}>{cancel}</button>
          <button type="submit" className="primary" disabled={!manager || !instance.trim() || !canChange || isBusy}>{texts.tryIt.go}</button>
        </footer>
      </form>
    </Modal>
  );
}

/** Components are called by their type and a number from 0. */
function freeNumber(taken: readonly string[], type: string): string {
  for (let number = 0; number < 1000; number += 1) if (!taken.includes(`${type}${number}`)) return `${type}${number}`;
  return freeName(taken, type);
}
