import type { Sample } from '../server/values';

const STAMP = /^\[\d+\.\d{9}\] /;
/** A value in a few signs, for a wire: its numbers where it has some, else its text; cut to what there is room for. */
export function shortValue(sample: Sample | undefined, most: number): string {
  if (sample?.text === undefined) return '';
  const numbers = Object.values(sample.numbers ?? {});
  const text = numbers.length ? numbers.map((each) => (each === null ? '–' : String(Number(each.toPrecision(3))))).join(', ') : plainText(sample);
  return text.length <= most ? text : `${text.slice(0, Math.max(most - 1, 1)).replace(/,? *$/, '')}…`;
}

/** The text of a value without its time stamp, which stands elsewhere. */
export const plainText = (sample: Sample): string => (sample.text ?? '').replace(STAMP, '');

/** What is amiss at the in end of a wire: values that it has dropped, or a buffer that is more than half full. */
export interface Pressure { waiting: number; length: number; dropped: number; isTight: boolean }

export function pressureAt(sample: Sample | undefined, connector: string): Pressure | null {
  const buffer = sample?.buffers?.[connector];
  if (!buffer) return null;
  const [waiting, length, dropped] = buffer;
  return { waiting, length, dropped, isTight: length > 1 && waiting * 2 > length };
}

/** After this without a value a flow of unknown rate has dried up [s]. */
const STALE_AFTER = 5;

/** A flow has dried up when it has brought values, and brings none now; a process that stands still tells no rate. */
export function isStale(hz: number | null, sample: Sample | undefined, now: number): boolean {
  if (!sample || (!sample.count && sample.at === null)) return false;
  return hz === null ? sample.at !== null && now - sample.at > STALE_AFTER : hz === 0;
}

/** Columns for a plot of one port: times, then the numbers of each field; null where a value has none. */
export interface Curves { names: string[]; times: number[]; columns: (number | null)[][] }

/** More curves than these nobody can tell apart. */
export const MOST_CURVES = 6;

export function curvesOf(samples: readonly Sample[]): Curves {
  const names = Object.keys(samples.at(-1)?.numbers ?? {}).slice(0, MOST_CURVES);
  return {
    names,
    times: samples.map(({ at }) => at ?? 0),
    columns: names.map((name) => samples.map(({ numbers }) => numbers?.[name] ?? null)),
  };
}
