import { useId, useState } from 'react';

import { Icon } from '../../parts/icons';
import { StateIcon } from '../../parts/StateIcon';
import type { Look } from '../../model/types';
import { isActive } from './draft';
import { eventsOf } from './Inspector';
import type { Live } from './live';
import type { MachineRecord, Standing } from './types';
import { useMachineTexts } from './useMachine';

const LOOKS: Record<Standing['run'], Look> = { running: 'active', paused: 'inactive', stopped: 'created', done: 'unknown' };
const OFFERED = 4;

interface Props { live: Live & { machine: MachineRecord }; canChange: boolean; onRun: (word: string) => void; onEvent: (name: string) => void }

/** Runs the machine that lives, sends it events, and tells how it stands. */
export function RunBar({ live: { machine, standing }, canChange, onRun, onEvent }: Props) {
  const texts = useMachineTexts();
  const id = useId();
  const [event, setEvent] = useState('');
  if (!standing) return null;
  const { run, status, state } = standing;
  const waits = [...new Set(machine.states.filter((one) => isActive(one.path, state)).flatMap((one) => one.transitions.map((way) => way.on)))].filter((one) => eventsOf(machine).includes(one));
  const isStanding = run !== 'running' && run !== 'paused';
  return (
    <div className="run-bar">
      <span className={`word look-${LOOKS[run]}`}><StateIcon look={LOOKS[run]} />{texts.runs[run]}</span>
      {run === 'paused' && <span className="note" title={status}>{status.replace(/^paused in \S+: /, '')}</span>}
      <div className="buttons" role="group" aria-label={texts.controls}>
        <button type="button" disabled={!canChange || run === 'running'} onClick={() => onRun('start')}><Icon name="play" />{run === 'paused' ? texts.resume : texts.start}</button>
        <button type="button" disabled={!canChange || run !== 'running'} onClick={() => onRun('pause')}><Icon name="pause" />{texts.pause}</button>
        <button type="button" disabled={!canChange || run !== 'paused'} onClick={() => onRun('step')}>{texts.step}</button>
        <button type="button" disabled={!canChange || (isStanding && !state)} onClick={() => onRun('stop')}>{texts.stop}</button>
      </div>
      <form className="row" onSubmit={(submitted) => {
        submitted.preventDefault();
        if (event.trim()) onEvent(event.trim());
      }}>
        <input type="text" aria-label={texts.event} placeholder={texts.event} value={event} list={`${id}-events`} disabled={!canChange} spellCheck={false} onChange={(typed) => setEvent(typed.target.value)} />
        <datalist id={`${id}-events`}>{eventsOf(machine).map((one) => <option key={one} value={one} />)}</datalist>
        <button type="submit" disabled={!canChange || !event.trim()}>{texts.send}</button>
      </form>
      {waits.length > 0 && (
        <div className="buttons waits" role="group" aria-label={texts.waits}>
          {waits.slice(0, OFFERED).map((one) => <button key={one} type="button" disabled={!canChange} title={texts.sendOf(one)} onClick={() => onEvent(one)}>{one}</button>)}
        </div>
      )}
    </div>
  );
}
