import { Fragment, useState } from 'react';

import { Icon } from '../../parts/icons';
import type { StepNews, StepState } from './progress';
import type { PlanStep } from './types';
import type { PlanTexts } from './usePlanTexts';

const SIGNS: Readonly<Record<StepState, string>> = { waiting: '·', begun: '▶', done: '✓', held: '=', failed: '✕', left: '○' };

interface Props { texts: PlanTexts; steps: readonly PlanStep[]; news: ReadonlyMap<number, StepNews> | null }

/** The steps of a plan by layers, with what became of each where the plan is carried out; apart from them what needs no step. */
export function StepTable({ texts, steps, news }: Props) {
  const layers = new Map<number, PlanStep[]>();
  for (const step of steps) if (!step.holds) layers.set(step.layer, [...(layers.get(step.layer) ?? []), step]);
  const held = steps.filter((step) => step.holds);
  // A plain sequence needs no heading for each of its steps.
  const hasLayers = [...layers.values()].some((layer) => layer.length > 1);
  const columns = 4 + (news ? 2 : 0);
  if (!steps.length) return null;
  return (
    <>
      {layers.size > 0 && (
        <table className="steps">
          <thead>
            <tr>{news && <th>{texts.stateHead}</th>}<th className="number">#</th><th>{texts.step}</th><th>{texts.change}</th><th className="number">{texts.costHead}</th>{news && <th className="number">{texts.took}</th>}</tr>
          </thead>
          <tbody>
            {[...layers].map(([layer, inIt]) => (
              <Fragment key={layer}>
                {hasLayers && <tr className="layer"><th colSpan={columns} scope="rowgroup">{texts.layer(layer)}{inIt.length > 1 && <span className="note"> {texts.atOnce(inIt.length)}</span>}</th></tr>}
                {inIt.map((step) => <Row key={step.number} texts={texts} step={step} news={news?.get(step.number) ?? null} />)}
              </Fragment>
            ))}
          </tbody>
        </table>
      )}
      {held.length > 0 && <details className="held"><summary>{texts.held(held.length)}</summary><ul>{held.map((step) => <li key={step.number}>{step.text}</li>)}</ul></details>}
    </>
  );
}

function Row({ texts, step, news }: { texts: PlanTexts; step: PlanStep; news: StepNews | null }) {
  const from = texts.costFrom[step.cost_from] ?? '';
  const bad = news?.why || (news ? '' : step.blocked);
  return (
    <tr className={news?.state === 'failed' ? 'is-bad' : ''}>
      {news && <td className={`step-state is-${news.state}`}><span aria-hidden="true">{SIGNS[news.state]}</span> {texts.states[news.state]}</td>}
      <td className="number">{step.number}</td>
      <td>{step.text}{step.required && <span className="note"> {texts.required}</span>}{bad && <p className="bad">{bad}</p>}</td>
      <td><code>{step.change}</code></td><td className="number">{step.cost}{from && <span className="note"> {from}</span>}</td>
      {news && <td className="number">{news.tookS === null ? '' : texts.ms(Math.max(1, Math.round(news.tookS * 1000)))}</td>}
    </tr>
  );
}

/** What must hold before anything is done; what does not is shown. */
export function CheckList({ texts, checks }: { texts: PlanTexts; checks: readonly { text: string; failure: string }[] }) {
  if (!checks.length) return null;
  const bad = checks.filter(({ failure }) => failure);
  return (
    <details open={bad.length > 0}>
      <summary>{texts.checks(checks.length)}</summary>
      <ul>{checks.map(({ text, failure }) => <li key={text}>{text}{failure && <p className="bad">{failure}</p>}</li>)}</ul>
    </details>
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
