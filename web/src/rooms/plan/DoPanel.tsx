import { useState } from 'react';

import { lackingFor } from '../../model/rights';
import type { System } from '../../model/system';
import type { Job } from '../../model/types';
import { RightsNote } from '../../panels/RightsGate';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { AS_IT_IS, HostTable, type Mapping } from './HostTable';
import { PartTable } from './PartTable';
import { withoutParts } from './parts';
import type { Place } from './place';
import { CheckList, CommandLine, StepTable } from './StepTable';
import { DEEDS, FLAGS, NEEDED, STATES, type Deed, type Flag, type Plan, type PlanRequest } from './types';
import { useProfile } from './useProfile';
import type { PlanTexts } from './usePlanTexts';

/** What can be done without a file: the profile is what lives. */
const LIVE: readonly Deed[] = ['start', 'stop', 'take_down'];

interface Shown { request: PlanRequest; plan: Plan }

/** Chooses what to do, shows the plan of it, and has it done. */
export function DoPanel({ texts, file, system, onGo }: { texts: PlanTexts; file: string; system: System; onGo: (to: Partial<Place>) => void }) {
  const { api, canChange } = useEditor();
  const deeds = file ? DEEDS : LIVE;
  const [deed, setDeed] = useState<Deed>(file ? 'apply' : 'start');
  const [flags, setFlags] = useState<readonly Flag[]>([]);
  const [state, setState] = useState<(typeof STATES)[number]>('active');
  const [mapping, setMapping] = useState<Mapping>(AS_IT_IS);
  const { profile, problem: unread } = useProfile(file);
  const [shown, setShown] = useState<Shown | null>(null);
  const [isBusy, setBusy] = useState(false);
  const [problem, setProblem] = useState('');
  // A plan that was shown is of what was chosen then.
  const changed = <T,>(set: (value: T) => void) => (value: T) => {
    set(value);
    setShown(null);
    setProblem('');
  };
  const choose = changed(setDeed);
  const wait = async (work: Promise<void>) => {
    setBusy(true);
    setProblem('');
    await work.catch((error: unknown) => setProblem(sentence(error)));
    setBusy(false);
  };
  const { map, place, set, prefix, left } = mapping;
  const placed = Object.fromEntries(Object.entries(place).filter(([name]) => !left.has(name)));
  const request: PlanRequest = { do: deed, file, flags: flags.filter((flag) => FLAGS[deed].includes(flag)), ...(deed === 'apply' && { state }), ...(file && { map, place: placed, set, prefix, without: profile ? withoutParts(profile, left) : [] }) };
  const hosts = new Set((profile?.components ?? []).map(({ host }) => map[host] ?? host));
  const lacking = lackingFor(system, NEEDED[deed], hosts);
  const look = () => wait(api.post<Plan>('/api/plans/show', request).then((plan) => setShown({ request, plan })));
  const start = ({ request: asked, plan }: Shown) =>
    wait(api.post<Job>('/api/plans/start', { ...asked, shown: plan.steps.map((step) => step.text) }).then((job) => onGo({ tab: 'job', of: job.id })));
  return (
    <>
      <form className="plans-form" onSubmit={(event) => { event.preventDefault(); void look(); }}>
        <fieldset className="deeds">
          <legend className="unseen">{texts.deed}</legend>
          {deeds.map((one) => (
            <label key={one} className={one === deed ? 'is-chosen' : ''}>
              <input type="radio" name="deed" checked={one === deed} onChange={() => choose(one)} />{texts.deeds[one]}
            </label>
          ))}
        </fieldset>
        <p className="note">{texts.deedHints[deed]}</p>
        {(FLAGS[deed].length > 0 || deed === 'apply') && (
          <fieldset className="row">
            <legend className="unseen">{texts.options}</legend>
            {deed === 'apply' && (
              <label>{texts.state} <select value={state} onChange={(event) => changed(setState)(event.target.value as typeof state)}>
                {STATES.map((one) => <option key={one} value={one}>{texts.goal[one]}</option>)}
              </select></label>
            )}
            {FLAGS[deed].map((flag) => (
              <label key={flag} className="check">
                <input type="checkbox" checked={flags.includes(flag)} onChange={() => changed(setFlags)(flags.includes(flag) ? flags.filter((one) => one !== flag) : [...flags, flag])} />{texts.flags[flag]}
              </label>
            ))}
          </fieldset>
        )}
        {profile && profile.components.length > 0 && <PartTable texts={texts} profile={profile} system={system} mapping={mapping} onChange={changed(setMapping)} />}
        {profile && <HostTable texts={texts} profile={profile} mapping={mapping} onChange={changed(setMapping)} />}
        {unread && <p className="error" role="alert">{unread}</p>}
        <div className="row">
          <button type="submit" className={shown ? '' : 'primary'} disabled={isBusy}>{texts.plan}</button>
          {isBusy && <span className="note" role="status">{texts.planning}</span>}
        </div>
      </form>
      {problem && <p className="error" role="alert">{problem}</p>}
      {shown && (
        <section aria-label={shown.plan.text} aria-live="polite">
          <Head texts={texts} plan={shown.plan} />
          <CommandLine texts={texts} command={shown.plan.command} />
          {shown.plan.notes.length > 0 && <ul className="warning">{shown.plan.notes.map((note) => <li key={note}>{note}</li>)}</ul>}
          {lacking && <RightsNote system={system} ids={[lacking.id]} />}
          {shown.plan.steps.some((step) => !step.holds) && (
            <button type="button" className={deed === 'take_down' ? 'danger filled' : 'primary'} disabled={!canChange || isBusy || Boolean(lacking)} onClick={() => void start(shown)}>{texts.go(texts.deeds[deed])}</button>
          )}
          <CheckList texts={texts} checks={shown.plan.checks ?? []} />
          <StepTable texts={texts} steps={shown.plan.steps} news={null} />
        </section>
      )}
    </>
  );
}

/** What a plan comes to. */
function Head({ texts, plan }: { texts: PlanTexts; plan: Plan }) {
  const { steps, cost, optimal, gap = 0, kept } = plan;
  const count = steps.filter((step) => !step.holds).length;
  if (!count) return <p>{texts.nothing}</p>;
  const parts = [texts.steps(count), texts.cost(cost), ...(optimal === undefined ? [] : [gap ? texts.gap(gap) : texts.optimal])];
  return <p><strong>{parts.join(' · ')}</strong>{kept && <span className="note"> {texts.kept(kept.managers, kept.components, kept.connections)}</span>}</p>;
}
