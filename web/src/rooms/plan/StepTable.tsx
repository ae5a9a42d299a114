import { Fragment, useState } from 'react';

import { Icon } from '../../parts/icons';
import type { StepState } from './progress';
import type { Plan, PlanStep } from './types';
import type { PlanTexts } from './usePlanTexts';

const SIGNS: Readonly<Record<StepState, string>> = { waiting: '·', begun: '▶', done: '✓', held: '=', failed: '✕', left: '○' };

interface Props { texts: PlanTexts; plan: Plan; states: ReadonlyMap<number, StepState> | null }

/** The steps of a plan: by layers where its command tells them, with the state of each where it is carried out. */
export function StepTable({ texts, plan, states }: Props) {
  const checks = plan.steps.filter((step) => step.kind === 'check');
  const layers = new Map<number, PlanStep[]>();
  for (const step of plan.steps) if (step.kind !== 'check') layers.set(step.layer ?? 0, [...(layers.get(step.layer ?? 0) ?? []), step]);
  const hasCosts = plan.cost !== undefined;
  const columns = 2 + (hasCosts ? 2 : 0) + (states ? 1 : 0);
  if (!plan.steps.length) return null;
  return (
    <>
      {checks.length > 0 && <details><summary>{texts.checks(checks.length)}</summary><ul>{checks.map((step) => <li key={step.number}>{step.text}</li>)}</ul></details>}
      <table className="steps">
        <thead>
          <tr>{states && <th>{texts.stateHead}</th>}<th className="number">#</th><th>{texts.step}</th>{hasCosts && <><th>{texts.change}</th><th className="number">{texts.costHead}</th></>}</tr>
        </thead>
        <tbody>
          {[...layers].map(([layer, steps]) => (
            <Fragment key={layer}>
              {layer > 0 && <tr className="layer"><th colSpan={columns} scope="rowgroup">{texts.layer(layer)}{steps.length > 1 && <span className="note"> {texts.atOnce(steps.length)}</span>}</th></tr>}
              {steps.map((step) => <Row key={step.number} texts={texts} step={step} state={states?.get(step.number) ?? null} hasCosts={hasCosts} />)}
            </Fragment>
          ))}
        </tbody>
      </table>
    </>
  );
}

function Row({ texts, step, state, hasCosts }: { texts: PlanTexts; step: PlanStep; state: StepState | null; hasCosts: boolean }) {
  const from = texts.costFrom[step.cost_from ?? ''] ?? '';
  return (
    <tr className={state === 'failed' ? 'is-bad' : ''}>
      {state && <td className={`step-state is-${state}`}><span aria-hidden="true">{SIGNS[state]}</span> {texts.states[state]}</td>}
      <td className="number">{step.number}</td>
      <td>{step.text}{step.required && <span className="note"> {texts.required}</span>}</td>
      {hasCosts && <><td><code>{step.change}</code></td><td className="number">{step.cost}{from && <span className="note"> {from}</span>}</td></>}
    </tr>
  );
}

/** A command line, ready to be copied. */
export function CommandLine({ texts, command }: { texts: PlanTexts; command: string }) {
  const [isCopied, setCopied] = useState(false);
  const copy = () => void navigator.clipboard.writeText(command).then(() => setCopied(true));
  return (
    <p className="command"><code aria-label={texts.command}>{command}</code>
      <button type="button" className="quiet" onClick={copy}><Icon name="copy" />{isCopied ? texts.copied : texts.copy}</button></p>
  );
}
