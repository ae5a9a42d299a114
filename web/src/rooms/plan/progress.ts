import type { Job, JobRow } from '../../model/types';
import type { Plan, PlanRequest, PlanStep } from './types';

/** `held`: it was so already; `left`: the job ended before it. */
export type StepState = 'waiting' | 'begun' | 'done' | 'held' | 'failed' | 'left';

/** What became of a step: for how long it was at work [s], why it failed. */
export interface StepNews { state: StepState; tookS: number | null; why: string }

/** One plan and what became of its steps, by their numbers. A job has more than one where it planned anew. */
export interface Part { steps: readonly PlanStep[]; reason: string; news: ReadonlyMap<number, StepNews> }

/** What went wrong, with what comes of it below; `left` steps were not done. */
export interface Trouble { text: string; below: Trouble[]; left?: number }

export interface Progress { parts: readonly Part[]; done: number; all: number; trouble: Trouble | null }

interface Told { plan: Plan | null; request: PlanRequest | null; parts: Part[]; notes: string[] }

/** The plan that a job carries out, who asked for it how, and what its command has told so far: records `plan` and `step`, see docs/json.md. */
export function toldBy(rows: readonly JobRow[]): Told {
  const first = rows[0] as { plan?: Plan; request?: PlanRequest } | undefined;
  const plan = first?.plan ?? null;
  let [part, news] = begun(plan?.steps ?? [], '');
  const parts = [part];
  const notes: string[] = [];
  for (const row of rows.slice(1)) {
    if (typeof row.stderr === 'string') notes.push(row.stderr);
    else if (row.schema === 'rtkit.plan/1') {
      // The plan that was shown is the same as that of the command, unless this one is told why it was made.
      const isFurther = typeof row.reason === 'string' || news.size > 0;
      [part, news] = begun(row.steps as PlanStep[], typeof row.reason === 'string' ? row.reason : '');
      parts.splice(isFurther ? parts.length : parts.length - 1, 1, part);
    } else if (row.schema === 'rtkit.step/1') {
      const { number, state, took_s: tookS, why } = row as unknown as { number: number; state: StepState; took_s: number | null; why: string };
      news.set(number, { state, tookS, why });
    }
  }
  return { plan, request: first?.request ?? null, parts, notes };
}

function begun(steps: readonly PlanStep[], reason: string): [Part, Map<number, StepNews>] {
  const news = new Map<number, StepNews>();
  return [{ steps, reason, news }, news];
}

/** How far a job is: of steps that nothing was told of, the end of the job tells what became. */
export function progressOf(told: readonly Part[], job: Pick<Job, 'status' | 'error' | 'text'>): Progress {
  const parts = told.map((part, index) => {
    const isOver = job.status !== null || index < told.length - 1;
    const isReached = job.status === 0 && index === told.length - 1;
    const news = new Map(part.steps.map(({ number }) => [number, ended(part.news.get(number) ?? { state: 'waiting', tookS: null, why: '' }, isOver, isReached)]));
    return { ...part, news };
  });
  const last = [...(parts.at(-1)?.news.values() ?? [])];
  const isDone = ({ state }: StepNews) => state === 'done' || state === 'held';
  return { parts, done: last.filter(isDone).length, all: last.length, trouble: troubleOf(parts, job) };
}

function ended(news: StepNews, isOver: boolean, isReached: boolean): StepNews {
  if (!isOver || (news.state !== 'waiting' && news.state !== 'begun')) return news;
  return { ...news, state: !isReached ? 'left' : news.state === 'begun' ? 'done' : 'held' };
}

/** One tree: each step that failed with its cause, what the command said of it, and what is left. */
function troubleOf(parts: readonly Part[], job: Pick<Job, 'error' | 'text' | 'status'>): Trouble | null {
  if (job.status === null) return null;
  const steps = parts.flatMap(({ steps: all, news }) => all.map((step) => ({ step, ...news.get(step.number) })));
  const failed = steps.filter(({ state }) => state === 'failed');
  if (job.status === 0 && !failed.length) return null;
  const below: Trouble[] = failed.map(({ step, why = '' }) => ({ text: step.text, below: [{ text: why, below: [] }] }));
  const said = failed.length ? (job.error.split('\n').at(-1) ?? '').split('; ').filter((part) => !failed.some(({ why }) => why && part.includes(why))) : job.error.split('\n');
  below.push(...said.filter(Boolean).map((text) => ({ text, below: [] })));
  const left = [...(parts.at(-1)?.steps ?? [])].filter(({ number }) => parts.at(-1)?.news.get(number)?.state === 'left');
  if (left.length) below.push({ text: '', left: left.length, below: left.map(({ text }) => ({ text, below: [] })) });
  return { text: job.text, below };
}
