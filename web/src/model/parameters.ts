/** How a configuration parameter is shown, by its widget and its constraint. */
export type Widget =
  | { kind: 'text' }
  | { kind: 'slider'; low: number; high: number; step: number }
  | { kind: 'spin'; low: number | null; high: number | null; step: number }
  | { kind: 'radio' | 'checkbox' | 'ordered_list'; choices: string[] };

/** A constraint as far as the page can check it; the server checks all of it. */
export interface Constraint {
  low: number | null; isLowOpen: boolean; high: number | null; isHighOpen: boolean; choices: string[];
}

const NUMBER = '[-+]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eE][-+]?\\d+)?';
const BELOW = new RegExp(`^(${NUMBER})\\s*(<=?)\\s*x(?:\\s*(<=?)\\s*(${NUMBER}))?$`);
const ABOVE = new RegExp(`^(${NUMBER})\\s*(>=?)\\s*x(?:\\s*(>=?)\\s*(${NUMBER}))?$`);
const ONE_SIDE = new RegExp(`^x\\s*(<=?|>=?)\\s*(${NUMBER})$`);
const FREE: Constraint = { low: null, isLowOpen: false, high: null, isHighOpen: false, choices: [] };
const LISTS = new Set(['checkbox', 'ordered_list']);

/** Reads `0<=x<=50`, `x>0`, `(a, b, c)`; null for what only the server understands. */
export function parseConstraint(text: string): Constraint | null {
  const rule = text.trim();
  if (/^\(.*\)$/.test(rule)) return { ...FREE, choices: splitList(rule.slice(1, -1)) };
  const below = BELOW.exec(rule);
  if (below) return range(below[1], below[2] === '<', below[4], below[3] === '<');
  const above = ABOVE.exec(rule);
  if (above) return range(above[4], above[3] === '>', above[1], above[2] === '>');
  const one = ONE_SIDE.exec(rule);
  if (!one) return null;
  const isOpen = one[1]?.length === 1;
  return one[1]?.startsWith('<') ? range(undefined, false, one[2], isOpen) : range(one[2], isOpen, undefined, false);
}

function range(low: string | undefined, isLowOpen: boolean, high: string | undefined, isHighOpen: boolean): Constraint {
  return { ...FREE, low: low === undefined ? null : Number(low), isLowOpen, high: high === undefined ? null : Number(high), isHighOpen };
}

/** Elements of a comma-separated text, without the spaces around them. */
export const splitList = (text: string): string[] => text.split(',').map((part) => part.trim()).filter(Boolean);

/** The widget for a parameter; one that its constraint cannot serve is a text field. */
export function widgetFor(widget: string, constraintText: string): Widget {
  const constraint = parseConstraint(constraintText);
  const [kind = '', ...rest] = widget.split('.');
  const step = Number(rest.join('.'));
  const { low, high, choices } = constraint ?? FREE;
  if (kind === 'slider' && low !== null && high !== null)
    return { kind, low, high, step: step > 0 ? step : (high - low) / 100 };
  if (kind === 'spin' || kind === 'slider') return { kind: 'spin', low, high, step: step > 0 ? step : 1 };
  if ((kind === 'radio' || kind === 'checkbox' || kind === 'ordered_list') && choices.length) return { kind, choices };
  return { kind: 'text' };
}

export type Misfit = { kind: 'not-a-number' } | { kind: 'must-satisfy'; rule: string } | { kind: 'not-offered'; value: string } | null;

/** Why a text breaks the constraint, or null; what cannot be read here is left to the server. */
export function misfit(text: string, constraintText: string, widget = ''): Misfit {
  const constraint = parseConstraint(constraintText);
  if (!constraint) return null;
  if (constraint.choices.length) {
    const values = LISTS.has(widget) ? splitList(text) : [text.trim()];
    const wrong = values.find((value) => !constraint.choices.includes(value));
    return wrong === undefined ? null : { kind: 'not-offered', value: wrong };
  }
  // A parameter may hold several numbers: the constraint is one for each.
  const numbers = text.split(',').map((part) => (part.trim() === '' ? Number.NaN : Number(part)));
  if (numbers.some(Number.isNaN)) return { kind: 'not-a-number' };
  return numbers.every((value) => isWithin(value, constraint)) ? null : { kind: 'must-satisfy', rule: constraintText };
}

function isWithin(value: number, { low, isLowOpen, high, isHighOpen }: Constraint): boolean {
  const isHighEnough = low === null || (isLowOpen ? value > low : value >= low);
  const isLowEnough = high === null || (isHighOpen ? value < high : value <= high);
  return isHighEnough && isLowEnough;
}
