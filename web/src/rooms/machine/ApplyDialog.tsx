import { useState } from 'react';

import { Modal } from '../../parts/Modal';
import type { Difference } from './diff';
import { ChoiceField } from './fields';
import type { MachineRecord, Problem } from './types';
import { useMachineTexts } from './useMachine';

interface Props {
  name: string; found: readonly Difference[]; problems: readonly Problem[]; machine: MachineRecord;
  /** The active state, where the draft does not have it any more. */
  lost: string; hasComments: boolean;
  onApply: (goto: string) => Promise<boolean>; onClose: () => void;
}

/** Shows the edit as a difference, asks where to go from a state that would be gone, and applies it whole. */
export function ApplyDialog({ name, found, problems, machine, lost, hasComments, onApply, onClose }: Props) {
  const texts = useMachineTexts();
  const words = texts.diff;
  const [goto, setGoto] = useState('');
  const [isBusy, setBusy] = useState(false);
  const wrong = problems.filter((one) => !one.is_odd);
  const isReady = found.length > 0 && wrong.length === 0 && (!lost || goto !== '') && !isBusy;
  const apply = async () => {
    setBusy(true);
    if (await onApply(lost ? goto : '')) onClose();
    else setBusy(false);
  };
  return (
    <Modal title={words.title(name)} className="machine-diff" onClose={onClose}>
      <form method="dialog" onSubmit={(event) => { event.preventDefault(); if (isReady) void apply(); }}>
        <p>{words.lead}</p>
        {found.length === 0 && <p className="empty">{words.none}</p>}
        <DiffList found={found} />
        {hasComments && <p className="note">{words.reformatted}</p>}
        {wrong.length > 0 && (
          <div role="alert">
            <p className="error">{words.wrong}</p>
            <ul>{wrong.map((one) => <li key={one.state + one.part + one.text} className="error">{texts.problemOf(one.state, one.text)}</li>)}</ul>
          </div>
        )}
        {lost && (
          <div className="goto" role="group" aria-label={words.gotoLead(lost)}>
            <p className="warning">⚠ {words.gotoLead(lost)}</p>
            <ChoiceField label={words.goto} value={goto} choices={[['', words.choose], ...machine.states.map((one) => [one.path, one.path] as const)]} onChange={setGoto} />
          </div>
        )}
        <footer>
          <button type="button" onClick={onClose}>{words.cancel}</button>
          <button type="submit" className="primary" disabled={!isReady}>{words.go}</button>
        </footer>
      </form>
    </Modal>
  );
}

export function DiffList({ found }: { found: readonly Difference[] }) {
  const texts = useMachineTexts();
  return (
    <ul className="diff">
      {found.map(({ sign, path, lines }) => (
        <li key={sign + path} data-sign={sign}>
          <b>{sign}</b> <strong>{path || texts.diff.machine}</strong> <span className="note">{texts.signs[sign]}</span>
          {lines.map((line, index) => <code key={index}>{line}</code>)}
        </li>
      ))}
    </ul>
  );
}
