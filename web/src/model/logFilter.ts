/** A record of a log, as `rtvlog --json` has it. */
export interface LogRecord {
  time: string; level: string; manager: string; process: string; component: string; pid: number; host: string; source: string; message: string; exception: string;
}

/** The records in a file: of `rtvlog --json`, of this page, or the log of a manager; `bad` is the number of lines that are none. */
export function recordsIn(text: string): { records: LogRecord[]; bad: number } {
  const lines = text.split('\n').filter((line) => line.trim());
  const records = lines.flatMap((line) => recordOf(line) ?? []);
  if (!records.length) throw new Error('This file has no records of a log: each line is one as “rtvlog --json” writes it.');
  return { records, bad: lines.length - records.length };
}

function recordOf(line: string): LogRecord | null {
  let read: unknown;
  try {
    read = JSON.parse(line);
  } catch {
    return null;
  }
  if (typeof read !== 'object' || read === null || !('time' in read) || !('message' in read) || Number.isNaN(Date.parse(String(read.time)))) return null;
  const fields = read as Record<string, unknown>;
  const text = (key: string): string => (typeof fields[key] === 'string' ? fields[key] : '');
  return {
    time: text('time'), level: text('level'), manager: text('manager'), process: text('process'), component: text('component'), pid: Number(fields['pid'] ?? 0),
    host: text('host'), source: text('source') || text('logger'), message: text('message'), exception: text('exception'),
  };
}

export const FIELDS = ['any', 'message', 'level', 'name', 'manager', 'host', 'pid', 'source'] as const;
export type Field = (typeof FIELDS)[number];

/** A condition on one field; its text is a regular expression where that is asked for. */
export interface Term { kind: 'term'; id: number; field: Field; isNot: boolean; isPattern: boolean; text: string }
/** Conditions that must all hold, or of which one must. */
export interface Group { kind: 'group'; id: number; join: 'and' | 'or'; parts: readonly Part[] }
export type Part = Term | Group;

/** What is shown: the conditions, and a range of time as `YYYY-MM-DDTHH:MM:SS` of this place; empty texts are no bound. */
export interface LogFilter { root: Group; from: string; to: string }

let last = 0;
const nextId = (): number => (last += 1);

export const newTerm = (): Term => ({ kind: 'term', id: nextId(), field: 'any', isNot: false, isPattern: false, text: '' });
export const newGroup = (join: Group['join'], parts: readonly Part[] = [newTerm()]): Group => ({ kind: 'group', id: nextId(), join, parts });
export const noFilter = (): LogFilter => ({ root: newGroup('and'), from: '', to: '' });

/** The name that is shown of a record: its component, else its process. */
export const nameOf = (record: LogRecord): string => record.component || record.process;

export function textOf(record: LogRecord, field: Field): string {
  if (field === 'name') return nameOf(record);
  if (field === 'message') return record.exception ? `${record.message}\n${record.exception}` : record.message;
  if (field === 'any') return [record.level, record.manager, nameOf(record), String(record.pid), record.host, record.source, record.message, record.exception].join('\n');
  return String(record[field]);
}

export type Test = (record: LogRecord) => boolean;

/** The test that a filter stands for; `problem` is the first pattern that is none, and such a term holds for nothing. */
export function testOf({ root, from, to }: LogFilter): { test: Test; problem: string } {
  const problems: string[] = [];
  const holds = partTest(root, problems);
  const [begin, end] = [momentOf(from, -Infinity), momentOf(to, Infinity)];
  return {
    problem: problems[0] ?? '',
    test: (record) => {
      const time = Date.parse(record.time);
      return time >= begin && time <= end && holds(record);
    },
  };
}

function momentOf(text: string, otherwise: number): number {
  const moment = text ? Date.parse(text) : otherwise;
  return Number.isNaN(moment) ? otherwise : moment;
}

function partTest(part: Part, problems: string[]): Test {
  if (part.kind === 'term') return termTest(part, problems);
  // A term without a text says nothing yet.
  const tests = part.parts.filter((each) => each.kind === 'group' || each.text !== '').map((each) => partTest(each, problems));
  if (!tests.length) return () => true;
  return part.join === 'and' ? (record) => tests.every((test) => test(record)) : (record) => tests.some((test) => test(record));
}

function termTest({ field, isNot, isPattern, text }: Term, problems: string[]): Test {
  if (!isPattern) {
    const wanted = text.toLowerCase();
    return (record) => textOf(record, field).toLowerCase().includes(wanted) !== isNot;
  }
  try {
    const pattern = new RegExp(text, 'im');
    return (record) => pattern.test(textOf(record, field)) !== isNot;
  } catch {
    problems.push(text);
    return () => false;
  }
}

/** The tree with one part replaced, or without it where the new one is null. A group that is left empty gets a new term. */
export function replaced(group: Group, id: number, by: Part | null): Group {
  const parts = group.parts.flatMap((part): Part[] => {
    if (part.id === id) return by ? [by] : [];
    return part.kind === 'group' ? [replaced(part, id, by)] : [part];
  });
  return { ...group, parts: parts.length ? parts : [newTerm()] };
}

/** A record as a line of text. */
export const lineOf = (record: LogRecord): string =>
  [record.time, record.level.padEnd(5), `${record.host}/${record.manager}`, nameOf(record), String(record.pid), record.message, ...(record.exception ? [record.exception] : [])].join('  ');
