import type { Job, JobRow } from '../../model/types';
import type { Plan, PlanRequest } from './types';

/** `held`: it was so already; `left`: the job ended before it. */
export type StepState = 'waiting' | 'begun' | 'done' | 'held' | 'failed' | 'left';

/** What went wrong, with what comes of it below. */
export interface Trouble { text: string; below: Trouble[] }

export interface Progress { states: ReadonlyMap<number, StepState>; done: number; trouble: Trouble | null; notes: string[] }

const DONE = /^(?:\[\d+\/\d+\]|done:) (.*)$/;
const BEGUN = /^Executing (.*?)(?: \(Required\))?$/;
const FAILED = /^(?:Required action failed|Action failed): (.*)$/;
/** Lines of progress that say no more than the steps do, and those round the list of what is left. */
const QUIET = /to be done$|^(?:at once|kept|costs): /;
const LEFT = /^ *\d+ {2}(\S.*?)(?: {2}.*)?$/;

interface Told { plan: Plan | null; request: PlanRequest | null; lines: string[] }

/** The plan that a job carries out, who asked for it how, and what its command has told so far. */
export function toldBy(rows: readonly JobRow[]): Told {
  const first = rows[0] as { plan?: Plan; request?: PlanRequest } | undefined;
  const lines = rows.flatMap((row) => (typeof row.stderr === 'string' ? [row.stderr] : []));
  return { plan: first?.plan ?? null, request: first?.request ?? null, lines };
}

/** How far a plan is, by what its command has told. */
export function progressOf(plan: Plan, lines: readonly string[], job: Pick<Job, 'status' | 'error' | 'text'>): Progress {
  const [done, begun] = [new Set<string>(), new Set<string>()];
  const failures: string[] = [];
  const left: string[] = [];
  const notes: string[] = [];
  let isLeftKnown = false;
  for (const line of lines) {
    const [isDone, isBegun, isFailed, isLeft] = [DONE.exec(line)?.[1], BEGUN.exec(line)?.[1], FAILED.exec(line)?.[1], LEFT.exec(line)?.[1]];
    if (isDone !== undefined) done.add(isDone);
    else if (isBegun !== undefined) begun.add(isBegun);
    else if (isFailed !== undefined) failures.push(isFailed);
    else if (line.startsWith('left: ')) isLeftKnown = true;
    else if (isLeftKnown && isLeft !== undefined) left.push(isLeft);
    else if (!QUIET.test(line)) notes.push(line);
  }
  const hasEnded = job.status !== null;
  const hasFailed = hasEnded && (job.status !== 0 || failures.length > 0);
  const states = new Map<number, StepState>();
  for (const step of plan.steps) {
    const isFailed = hasFailed && [...failures, ...notes].some((failure) => isAbout(failure, step.text));
    // A step that took none, because it was so already, is not among those that are left.
    const isHeld = job.status === 0 || (isLeftKnown && !left.includes(step.text));
    states.set(step.number, done.has(step.text) ? 'done' : isFailed ? 'failed'
      : begun.has(step.text) ? (hasEnded && job.status === 0 ? 'done' : hasEnded ? 'left' : 'begun')
      : !hasEnded ? 'waiting' : isHeld ? 'held' : 'left');
  }
  const trouble = hasFailed ? troubleOf(job, failures, left, notes) : null;
  return { states, done: [...states.values()].filter((state) => state === 'done' || state === 'held').length, trouble, notes: trouble ? [] : notes };
}

/** Whether a failure names just what a step is about: `connect A.out to B.in`, `…/A.rtc in execution context 0`. */
function isAbout(failure: string, step: string): boolean {
  if (failure === step || failure.startsWith(`${step}:`) || failure.startsWith(`${step};`)) return true;
  const paths = step.match(/\/\S+\.rtc(?::\S+)?/g);
  if (!paths || step.startsWith('Check ')) return false;
  return /^(\{\d+\} )?(\[.*\] )?(Activate|Deactivate|Connect|Disconnect|Create|Exit) /.test(step) && paths.every((path) => failure.includes(path));
}

/** One tree: what failed, below it each failure with its causes, then what comes of it. */
function troubleOf(job: Pick<Job, 'error' | 'text' | 'status'>, failures: readonly string[], left: readonly string[], notes: readonly string[]): Trouble {
  const below = [...new Set(failures)].map((failure) => {
    const [first = '', ...more] = failure.split('; ');
    return { text: first, below: more.map((text) => ({ text, below: [] as Trouble[] })) };
  });
  const others = notes.filter((note) => job.error.includes(note));
  below.push(...others.map((text) => ({ text, below: [] })));
  if (!below.length && job.error) below.push(...job.error.split('\n').map((text) => ({ text, below: [] })));
  const last = below.at(-1);
  const leaf = last?.below.find(({ text }) => / left$/.test(text));
  if (leaf) leaf.below = left.map((text) => ({ text, below: [] }));
  return { text: job.text, below };
}
