import { countsIn } from '../canvas/graph';
import type { System } from '../model/system';
import { Counts } from '../parts/Counts';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { Fields, Section } from './Fields';
import { Link } from './Link';
import { ManagerActions } from './ManagerActions';
import { VerbButtons } from './VerbButtons';

/** A manager or one of its slaves: its state and its components. */
export function ManagerInspector({ system, id }: { system: System; id: string }) {
  const texts = useTexts();
  const words = texts.inspector;
  const { canMake, open } = useEditor();
  const manager = system.managers.get(id);
  const process = system.processes.get(id);
  const owner = process?.manager ?? id;
  const components = [...system.components.values()].filter((one) => (manager ? one.manager : one.process) === id);
  const state = manager ? texts.managerStates[manager.state] : process ? texts.processStates[process.state] : '';
  const why = manager?.why ?? process?.why;
  return (
    <>
      <div className="headline"><h2>{manager?.name ?? process?.name}</h2><p>{texts.canvas.kinds[manager ? 'manager' : 'process']}, <strong>{state}</strong></p></div>
      {why && <p className="remark">{why}</p>}
      <Counts counts={countsIn(components)} />
      <div className="buttons">
        <button type="button" disabled={!canMake} onClick={() => open({ kind: 'create', manager: owner, slave: process?.is_slave ? process.name : '' })}>{texts.create.open}</button>
        <button type="button" disabled={!canMake} onClick={() => open({ kind: 'load', manager: owner })}>{texts.load.open}</button>
      </div>
      <ManagerActions system={system} manager={manager} process={process} />
      {components.length > 0 && <VerbButtons components={components} />}
      <Fields rows={[
        [words.manager, !manager && process ? <Link key="manager" id={process.manager} /> : ''],
        [words.host, manager?.host], [words.pid, String(manager?.pid || process?.pid || '')], [words.version, manager?.version],
        [words.path, <code key="path">{id}</code>],
      ]} />
      <Section title={texts.table.components} count={components.length}>
        <ul className="links">{components.map((one) => <li key={one.id}><Link id={one.id} text={one.name} /> <span className="note">{one.word}</span></li>)}</ul>
      </Section>
    </>
  );
}
