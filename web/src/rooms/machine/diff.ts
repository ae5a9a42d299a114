import { wayId, wayText } from './draft';
import type { ActionRecord, MachineRecord, StateRecord } from './types';

export type Sign = '+' | '−' | '~';
/** One difference: of a state, or of the machine where `path` is empty; its parts in words. */
export interface Difference { sign: Sign; path: string; lines: string[] }

/** Words for the parts of a state, in the language of the page. */
export interface PartWords {
  initial: string; final: string; doc: string; entry: string; exit: string; do: string; variables: string; name: string; order: string; atOnce: string;
}

const same = (one: unknown, other: unknown): boolean => JSON.stringify(one) === JSON.stringify(other);

/** What a draft has more, less and otherwise than the machine that it began with. */
export function differences(base: MachineRecord, draft: MachineRecord, words: PartWords): Difference[] {
  const [before, after] = [byPath(base), byPath(draft)];
  const found: Difference[] = [];
  const own = machineLines(base, draft, words);
  if (own.length) found.push({ sign: '~', path: '', lines: own });
  for (const [path, state] of after) {
    const old = before.get(path);
    if (!old) found.push({ sign: '+', path, lines: state.transitions.map((way) => `+ ${label(way, words)}`) });
    else if (!same(old, state)) found.push({ sign: '~', path, lines: stateLines(old, state, words) });
  }
  for (const path of before.keys()) if (!after.has(path)) found.push({ sign: '−', path, lines: [] });
  return found;
}

const byPath = (machine: MachineRecord): Map<string, StateRecord> => new Map(machine.states.map((one) => [one.path, one]));

function machineLines(base: MachineRecord, draft: MachineRecord, words: PartWords): string[] {
  const lines: string[] = [];
  if (base.name !== draft.name) lines.push(`${words.name}: ${base.name} → ${draft.name}`);
  if (base.initial !== draft.initial) lines.push(`${words.initial}: ${base.initial || '–'} → ${draft.initial || '–'}`);
  if (base.doc !== draft.doc) lines.push(words.doc);
  const values = (one: MachineRecord) => one.variables.map(({ name, value }) => `${name} = ${value}`);
  lines.push(...listLines(values(base), values(draft)).map((line) => `${words.variables}: ${line}`));
  const kept = draft.states.filter((one) => base.states.some((old) => old.path === one.path)).map((one) => one.path);
  const old = base.states.filter((one) => draft.states.some((now) => now.path === one.path)).map((one) => one.path);
  if (!lines.length && !same(kept, old)) lines.push(words.order);
  return lines;
}

function stateLines(old: StateRecord, now: StateRecord, words: PartWords): string[] {
  const lines: string[] = [];
  if (old.initial !== now.initial) lines.push(`${words.initial}: ${old.initial || '–'} → ${now.initial || '–'}`);
  if (old.is_final !== now.is_final) lines.push(`${now.is_final ? '+' : '−'} ${words.final}`);
  if (old.doc !== now.doc) lines.push(words.doc);
  for (const part of ['entry', 'exit', 'do'] as const)
    lines.push(...listLines(old[part].map(actionText), now[part].map(actionText)).map((line) => `${words[part]}: ${line}`));
  const [before, after] = [old.transitions.map((way) => label(way, words)), now.transitions.map((way) => label(way, words))];
  lines.push(...listLines(before, after));
  return lines.length ? lines : [words.order];
}

function label(way: StateRecord['transitions'][number], words: PartWords): string {
  const actions = way.actions.length ? ` (${way.actions.map(actionText).join('; ')})` : '';
  return `${wayText({ ...way, actions: [] }) || words.atOnce} → ${way.to || '↺'}${actions}`;
}

export function actionText({ kind, target, how, value, every }: ActionRecord): string {
  if (kind === 'raise') return `raise ${target}`;
  const given = how === 'get' ? `GET ${value}` : value;
  return `${target} ${how === 'expression' ? ':=' : '='} ${given}${every ? ` / ${every} s` : ''}`;
}

/** What went from a list and what came; a text that is there twice counts twice. */
function listLines(before: readonly string[], after: readonly string[]): string[] {
  const left = [...before];
  const came: string[] = [];
  for (const one of after) {
    const at = left.indexOf(one);
    if (at < 0) came.push(`+ ${one}`);
    else left.splice(at, 1);
  }
  return [...left.map((one) => `− ${one}`), ...came];
}

/** Signs of the states and transitions of a draft, to be drawn. */
export function marks(base: MachineRecord, draft: MachineRecord): Map<string, Sign> {
  const before = byPath(base);
  const found = new Map<string, Sign>();
  for (const state of draft.states) {
    const old = before.get(state.path);
    if (old && same(old, state)) continue;
    found.set(state.path, old ? '~' : '+');
    const known = new Set(old?.transitions.map((way) => JSON.stringify(way)));
    state.transitions.forEach((way, index) => {
      if (!known.has(JSON.stringify(way))) found.set(wayId(state.path, index), '+');
    });
  }
  return found;
}
