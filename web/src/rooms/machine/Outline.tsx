import { StateIcon } from '../../parts/StateIcon';
import type { Sign } from './diff';
import { actionText } from './diff';
import { inside, initialOf, isActive, nameOf, outerOf, wayId, wayText } from './draft';
import type { MachineRecord, Problem, StateRecord } from './types';
import { useMachineTexts } from './useMachine';

interface Props {
  machine: MachineRecord; selected: string; active: string; marks: ReadonlyMap<string, Sign>; problems: readonly Problem[]; canEdit: boolean;
  onSelect: (id: string) => void; onInside: (path: string) => void; onWay: (path: string) => void; onRemove: (id: string) => void;
}

/** The twin of the chart: states and transitions as a table, with the same edits. */
export function Outline(props: Props) {
  const texts = useMachineTexts();
  const { machine } = props;
  return (
    <div className="outline">
      {machine.states.length === 0 ? <p className="empty">{texts.empty}</p> : (
        <table>
          <thead><tr>{[texts.table.state, texts.table.kind, texts.table.actions, texts.table.transitions, texts.table.edit].map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
          <tbody>{nested(machine, '').map((state) => <Row key={state.path} {...props} state={state} />)}</tbody>
        </table>
      )}
    </div>
  );
}

const nested = (machine: MachineRecord, outer: string): StateRecord[] => inside(machine, outer).flatMap((one) => [one, ...nested(machine, one.path)]);

function Row({ machine, state, selected, active, marks, problems, canEdit, onSelect, onInside, onWay, onRemove }: Props & { state: StateRecord }) {
  const texts = useMachineTexts();
  const { path } = state;
  const words = [initialOf(machine, outerOf(path)) === path && texts.initial, state.is_final && texts.final, inside(machine, path).length > 0 && texts.composite].filter(Boolean);
  const sign = marks.get(path);
  const own = problems.filter((one) => one.state === path);
  const actions = (['entry', 'do', 'exit'] as const).flatMap((word) => state[word].map((one) => `${texts.diff.parts[word]}: ${actionText(one)}`));
  return (
    <tr className={selected === path ? 'is-selected' : ''}>
      <th scope="row" style={{ paddingInlineStart: 8 + 18 * (path.split('.').length - 1) }}>
        {sign && <b title={texts.signs[sign]}>{sign} </b>}
        <button type="button" className="link" aria-current={selected === path || undefined} onClick={() => onSelect(path)}>{nameOf(path)}</button>
        {isActive(path, active) && <span className="word look-active"><StateIcon look="active" />{texts.active}</span>}
        {own.map((one) => <p key={one.part + one.text} className={one.is_odd ? 'warning' : 'error'}>{one.text}</p>)}
      </th>
      <td>{words.join(', ')}</td>
      <td>{actions.map((one, index) => <div key={index}>{one}</div>)}</td>
      <td>
        {state.transitions.map((way, index) => (
          <div key={index}>
            <button type="button" className="link" onClick={() => onSelect(wayId(path, index))}>{marks.get(wayId(path, index)) && '+ '}{wayText(way) || texts.atOnce} → {way.to || '↺'}</button>
          </div>
        ))}
      </td>
      <td>
        <span className="buttons">
          <button type="button" disabled={!canEdit || state.is_final} onClick={() => onWay(path)}>{texts.addWay} …</button>
          <button type="button" disabled={!canEdit || state.is_final} onClick={() => onInside(path)}>{texts.addInside}</button>
          <button type="button" className="danger" disabled={!canEdit} onClick={() => onRemove(path)}>{texts.remove}</button>
        </span>
      </td>
    </tr>
  );
}
