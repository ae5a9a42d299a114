import { useState } from 'react';

import { Icon } from '../../parts/icons';
import { useEditor } from '../../shell/contexts';
import { moved, newStep, stepOf, stepText, type OrderStep } from './order';
import type { Profile } from './types';
import { useProfile } from './useProfile';
import type { PlanTexts } from './usePlanTexts';

/** The orders of a profile: which component comes when, and what it waits for. */
export function OrderPanel({ texts, file }: { texts: PlanTexts; file: string }) {
  const [looks, setLooks] = useState(0);
  const { profile, problem } = useProfile(file, looks);
  const [name, setName] = useState('activation');
  if (problem) return <p className="error" role="alert">{problem}</p>;
  if (!profile) return <p className="empty">{texts.loading}</p>;
  const steps = profile.orders[name] ?? [];
  return (
    <>
      <label>{texts.order} <select value={name} onChange={(event) => setName(event.target.value)}>
        {Object.keys(profile.orders).map((one) => <option key={one} value={one}>{texts.orders[one] ?? one}{profile.orders[one]?.length ? ` (${profile.orders[one].length})` : ''}</option>)}
      </select></label>
      <OrderTable key={`${name} ${steps.join(' ')}`} texts={texts} file={file} name={name} steps={steps} profile={profile} onWritten={() => setLooks(looks + 1)} />
    </>
  );
}

interface Props { texts: PlanTexts; file: string; name: string; steps: readonly string[]; profile: Profile; onWritten: () => void }

function OrderTable({ texts, file, name, steps: known, profile, onWritten }: Props) {
  const { perform, canChange } = useEditor();
  const [steps, setSteps] = useState<readonly OrderStep[]>(() => known.map(stepOf));
  const made = steps.map(stepText);
  const isChanged = made.join('\n') !== known.join('\n');
  const change = (index: number, to: Partial<OrderStep>) => setSteps(steps.map((step, at) => (at === index ? { ...step, ...to } : step)));
  const write = () => void perform([{ do: 'order', file, order: name, steps: made, expect: [...known] }], texts.writeLabel(texts.orders[name] ?? name, file)).then((isDone) => isDone && onWritten());
  const free = profile.components.map((one) => one.name).filter((one) => !steps.some((step) => step.name === one));
  return (
    <>
      {steps.length === 0 && <p className="empty">{texts.noOrder}</p>}
      {steps.length > 0 && (
        <table className="orders">
          <thead><tr><th>{texts.place}</th><th>{texts.component}</th><th>{texts.wait}</th><th>{texts.after}</th><th>{texts.timeout}</th><th /><th /></tr></thead>
          <tbody>
            {steps.map((step, index) => (
              <tr key={index}>
                <td><input type="number" min={0} aria-label={`${texts.place}: ${step.name}`} placeholder={`${index + 1}`} value={step.at} disabled={!canChange} onChange={(event) => change(index, { at: event.target.value })} /></td>
                <th scope="row">{step.name}</th>
                <td><input type="number" min={0} aria-label={`${texts.wait}: ${step.name}`} value={step.wait} disabled={!canChange || step.after.length > 0} onChange={(event) => change(index, { wait: event.target.value })} /></td>
                <td><select aria-label={`${texts.after}: ${step.name}`} value={step.after[0] ?? ''} disabled={!canChange || step.after.length > 1} onChange={(event) => change(index, { after: event.target.value ? [event.target.value] : [], wait: '' })}>
                  <option value="">{texts.nobody}</option>
                  {[...new Set([...profile.components.map((one) => one.name), ...step.after])].filter((one) => one !== step.name).map((one) => <option key={one} value={one}>{one === step.after[0] ? step.after.join(', ') : one}</option>)}
                </select></td>
                <td><input type="number" min={0} aria-label={`${texts.timeout}: ${step.name}`} value={step.timeout} disabled={!canChange || !step.after.length} onChange={(event) => change(index, { timeout: event.target.value })} /></td>
                <td><label className="check"><input type="checkbox" checked={step.isSent} disabled={!canChange || !step.after.length} onChange={(event) => change(index, { isSent: event.target.checked })} />{texts.sent}</label></td>
                <td><div className="buttons">
                  <RowButton icon="up" label={texts.up(step.name)} isDisabled={!canChange || index === 0} onClick={() => setSteps(moved(steps, index, index - 1))} />
                  <RowButton icon="down" label={texts.down(step.name)} isDisabled={!canChange || index === steps.length - 1} onClick={() => setSteps(moved(steps, index, index + 1))} />
                  <RowButton icon="close" label={texts.remove(step.name)} isDisabled={!canChange} onClick={() => setSteps(steps.filter((_, at) => at !== index))} />
                </div></td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <div className="row">
        {free.length > 0 && (
          <select aria-label={texts.add} value="" disabled={!canChange} onChange={(event) => setSteps([...steps, newStep(event.target.value)])}>
            <option value="">{texts.add}</option>
            {free.map((one) => <option key={one} value={one}>{one}</option>)}
          </select>
        )}
        <button type="button" className="primary" disabled={!canChange || !isChanged} onClick={write}>{texts.write}</button>
      </div>
    </>
  );
}

function RowButton({ icon, label, isDisabled, onClick }: { icon: 'up' | 'down' | 'close'; label: string; isDisabled: boolean; onClick: () => void }) {
  return <button type="button" className="quiet" aria-label={label} title={label} disabled={isDisabled} onClick={onClick}><Icon name={icon} /></button>;
}
