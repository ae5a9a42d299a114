import { zombies } from '../model/does';
import type { System } from '../model/system';
import type { Manager, Process } from '../model/types';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** Starts and ends slaves, restarts and stops a manager: each with the question what goes with it. */
export function ManagerActions({ system, manager, process }: { system: System; manager: Manager | undefined; process: Process | undefined }) {
  const { managers: words, label } = useTexts().manage;
  const { canMake, perform, open } = useEditor();
  const isUp = canMake && (manager ? manager.state === 'up' : true);
  if (!manager) {
    if (!process?.is_slave) return null;
    return <div className="buttons"><button type="button" className="danger" disabled={!isUp} onClick={() => void perform([{ do: 'end_slave', process: process.id }], label.endSlave(process.name))}>{words.endSlave}</button></div>;
  }
  const { id, name } = manager;
  const dead = zombies(system);
  return (
    <>
      <div className="buttons">
        <button type="button" disabled={!isUp} onClick={() => open({ kind: 'modules', manager: id })}>{words.modules} …</button>
        <button type="button" disabled={!isUp} onClick={() => void perform([{ do: 'fork', manager: id }], label.fork(name))}>{words.fork}</button>
      </div>
      <div className="buttons">
        {(id.startsWith('/localhost/') || manager.rights) && <button type="button" className="danger" disabled={!isUp} onClick={() => void perform([{ do: 'restart_manager', manager: id }], label.restart(name))}>{words.restart}</button>}
        <button type="button" className="danger" disabled={!isUp} title={words.stopHint} onClick={() => void perform([{ do: 'stop_manager', manager: id, keep: true }], label.stop(name))}>{words.stop}</button>
        <button type="button" className="danger" disabled={!isUp} title={words.shutDownHint} onClick={() => void perform([{ do: 'stop_manager', manager: id, keep: false }], label.shutDown(name))}>{words.shutDown}</button>
      </div>
      {dead.length > 0 && <div className="buttons"><button type="button" disabled={!canMake} onClick={() => void perform([{ do: 'forget_zombies' }], words.forgetZombies(dead.length))}>{words.forgetZombies(dead.length)}</button></div>}
    </>
  );
}
