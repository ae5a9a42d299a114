/** One row of a comparison: the line of each side, with its number from 1; null where a side has none. */
export interface DifferenceRow { kind: 'same' | 'added' | 'removed' | 'changed'; old: Line | null; new: Line | null }
export interface Line { number: number; text: string }

/** With more lines than these apart, no common ones are looked for between them. */
const MOST = 3000;

/** Compares two texts line by line. Lines that take each other's place stand in one row. */
export function compared(before: string, after: string): DifferenceRow[] {
  const [a, b] = [linesOf(before), linesOf(after)];
  let start = 0;
  while (start < a.length && start < b.length && a[start] === b[start]) start += 1;
  let end = 0;
  while (end < a.length - start && end < b.length - start && a[a.length - 1 - end] === b[b.length - 1 - end]) end += 1;
  const rows: DifferenceRow[] = [];
  let [i, j] = [0, 0];
  const same = () => {
    rows.push({ kind: 'same', old: lineOf(a, i), new: lineOf(b, j) });
    i += 1;
    j += 1;
  };
  const upTo = (x: number, y: number) => {
    while (i < x || j < y) {
      const [old, fresh] = [i < x ? lineOf(a, i) : null, j < y ? lineOf(b, j) : null];
      rows.push({ kind: old && fresh ? 'changed' : old ? 'removed' : 'added', old, new: fresh });
      if (old) i += 1;
      if (fresh) j += 1;
    }
  };
  while (i < start) same();
  for (const [x, y] of common(a.slice(start, a.length - end), b.slice(start, b.length - end))) {
    upTo(x + start, y + start);
    same();
  }
  upTo(a.length - end, b.length - end);
  while (i < a.length) same();
  return rows;
}

/** A file that ends in a line feed has no empty line behind it. */
export const linesOf = (text: string): string[] => (text === '' ? [] : text.replace(/\n$/, '').split('\n'));

const lineOf = (lines: readonly string[], index: number): Line => ({ number: index + 1, text: lines[index] ?? '' });

/** Pairs of equal lines, in order, as many as there are: the shortest edit by Myers. */
function common(a: readonly string[], b: readonly string[]): [number, number][] {
  const most = Math.min(a.length + b.length, MOST);
  let reached = new Map<number, number>([[1, 0]]);
  const kept: Map<number, number>[] = [];
  for (let edits = 0; edits <= most; edits += 1) {
    kept.push(new Map(reached));
    for (let k = -edits; k <= edits; k += 2) {
      const down = k === -edits || (k !== edits && (reached.get(k - 1) ?? -1) < (reached.get(k + 1) ?? -1));
      let x = down ? (reached.get(k + 1) ?? 0) : (reached.get(k - 1) ?? 0) + 1;
      while (x < a.length && x - k < b.length && a[x] === b[x - k]) x += 1;
      reached.set(k, x);
      if (x >= a.length && x - k >= b.length) return wayBack(kept, a.length, b.length);
    }
    reached = new Map([...reached].filter(([k]) => Math.abs(k) <= edits + 1));
  }
  return [];
}

function wayBack(kept: readonly Map<number, number>[], x: number, y: number): [number, number][] {
  const pairs: [number, number][] = [];
  for (let edits = kept.length - 1; edits >= 0; edits -= 1) {
    const reached = kept[edits] ?? new Map<number, number>();
    const k = x - y;
    const down = k === -edits || (k !== edits && (reached.get(k - 1) ?? -1) < (reached.get(k + 1) ?? -1));
    const before = down ? k + 1 : k - 1;
    const [startX, startY] = edits === 0 ? [0, 0] : [reached.get(before) ?? 0, (reached.get(before) ?? 0) - before];
    while (x > startX && y > startY) {
      x -= 1;
      y -= 1;
      pairs.push([x, y]);
    }
    [x, y] = [startX, startY];
  }
  return pairs.reverse();
}

/** Numbers of lines that came, went, or took another's place. */
export const counted = (rows: readonly DifferenceRow[]): { added: number; removed: number } => ({
  added: rows.filter((row) => row.kind !== 'same' && row.new).length,
  removed: rows.filter((row) => row.kind !== 'same' && row.old).length,
});

/** Rows without those that are far from any change; a number stands for how many are left out. */
export function near(rows: readonly DifferenceRow[], around = 3): (DifferenceRow | number)[] {
  const shown = rows.map(() => false);
  rows.forEach((row, index) => {
    if (row.kind !== 'same') shown.fill(true, Math.max(0, index - around), index + around + 1);
  });
  const found: (DifferenceRow | number)[] = [];
  rows.forEach((row, index) => {
    const last = found.at(-1);
    if (shown[index]) found.push(row);
    else if (typeof last === 'number') found[found.length - 1] = last + 1;
    else found.push(1);
  });
  return found;
}

/** The stamp of a file is another one after each change: what changed is told by another line. */
const STAMP = /Made by rtbuild.*\[[0-9a-f]{12}\]/;

/** The index of the first line of a text that another one does not have there; stamps do not count. */
export function firstChange(before: string, after: string): number {
  const [a, b] = [linesOf(before), linesOf(after)];
  const found = b.findIndex((line, index) => line !== a[index] && !STAMP.test(line));
  return found < 0 ? Math.max(0, b.length - 1) : found;
}
