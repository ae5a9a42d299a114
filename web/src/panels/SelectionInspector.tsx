import { countsIn } from '../canvas/graph';
import { wireText } from '../model/does';
import type { System } from '../model/system';
import { Counts } from '../parts/Counts';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { Link } from './Link';
import { VerbButtons } from './VerbButtons';
import { useVerbs } from './useVerbs';

/** Several components and connectors at once. */
export function SelectionInspector({ system, ids }: { system: System; ids: readonly string[] }) {
  const texts = useTexts();
  const { canChange, canMake, open } = useEditor();
  const { disconnect } = useVerbs();
  const components = ids.flatMap((id) => system.components.get(id) ?? []);
  const wires = ids.flatMap((id) => system.connectors.get(id) ?? []);
  return (
    <>
      <div className="headline"><h2>{texts.inspector.several(ids.length)}</h2></div>
      {components.length > 0 && <><Counts counts={countsIn(components)} /><VerbButtons components={components} /></>}
      {components.length > 1 && <div className="buttons"><button type="button" disabled={!canMake} onClick={() => open({ kind: 'compose', members: components.map((one) => one.id) })}>{texts.manage.composites.make}</button></div>}
      {wires.length > 0 && <div className="buttons"><button type="button" className="danger" disabled={!canChange} onClick={() => disconnect(wires)}>{texts.act.disconnect}</button></div>}
      <ul className="links">
        {components.map((one) => <li key={one.id}><Link id={one.id} /> <span className="note">{one.word}</span></li>)}
        {wires.map((one) => <li key={one.id}><Link id={one.id} text={wireText(one)} /></li>)}
      </ul>
    </>
  );
}
