import { countsIn } from '../canvas/graph';
import type { System } from '../model/system';
import { StateIcon } from '../parts/StateIcon';
import { zombies } from '../model/does';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { TROUBLED } from '../model/types';
import { Section } from './Fields';
import { Link } from './Link';

/** The whole system, when nothing is selected: counts, troubles and managers. */
export function Overview({ system }: { system: System }) {
  const texts = useTexts();
  const words = texts.inspector;
  const { managers } = texts.manage;
  const { canChange, perform, open } = useEditor();
  const dead = zombies(system).length;
  const components = [...system.components.values()];
  const troubled = components.filter((one) => TROUBLED.has(one.look));
  const wires = [...system.connectors.values()].filter((one) => one.trouble);
  return (
    <>
      <div className="headline"><h2>{words.overview}</h2><p>{system.host}</p></div>
      <Section title={words.countByState} count={components.length}>
        <ul className="states">
          {countsIn(components).map(([look, count]) => <li key={look} className={`look-${look}`}><StateIcon look={look} /><span>{texts.looks[look]}</span><strong>{count}</strong></li>)}
        </ul>
      </Section>
      {troubled.length + wires.length > 0 && (
        <Section title={words.trouble} count={troubled.length + wires.length}>
          <ul className="troubles">
            {troubled.map((one) => <li key={one.id}><StateIcon look={one.look} /><Link id={one.id} /><span className="note">{one.remark || one.word}</span></li>)}
            {wires.map((one) => <li key={one.id}><span aria-hidden="true">⚠</span><Link id={one.id} text={one.name} /><span className="note">{one.trouble}</span></li>)}
          </ul>
          {dead > 0 && <button type="button" disabled={!canChange} onClick={() => void perform([{ do: 'forget_zombies' }], managers.forgetZombies(dead))}>{managers.forgetZombies(dead)}</button>}
        </Section>
      )}
      <Section title={words.managers} count={system.managers.size}>
        <ul className="troubles">
          {[...system.managers.values()].map((one) => (
            <li key={one.id}><span aria-hidden="true">{one.state === 'up' ? '●' : '○'}</span><Link id={one.id} text={one.name} /><span className="note">{one.why || `${texts.managerStates[one.state]}, ${one.host}, ${one.version}`}</span></li>
          ))}
        </ul>
        <button type="button" disabled={!canChange} onClick={() => open({ kind: 'start' })}>{managers.start}</button>
      </Section>
      <p className="empty">{words.nothing}</p>
    </>
  );
}
