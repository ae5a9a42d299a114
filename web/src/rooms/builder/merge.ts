import type { Form } from './form';

/** Two forms brought together, and the places where both changed the same thing: there mine stays. */
export interface Merged { form: Form; conflicts: string[] }

type Value = unknown;
const isForm = (value: Value): value is Form => typeof value === 'object' && value !== null && !Array.isArray(value);
const isSame = (one: Value, other: Value): boolean => JSON.stringify(one) === JSON.stringify(other);

/** What both have made of a form, field by field; rows of lists are the same where their names are. */
export function mergedForms(base: Form, mine: Form, theirs: Form): Merged {
  const conflicts: string[] = [];
  return { form: mergedFields(base, mine, theirs, '', conflicts), conflicts };
}

function mergedFields(base: Form, mine: Form, theirs: Form, place: string, conflicts: string[]): Form {
  const keys = [...new Set([...Object.keys(mine), ...Object.keys(theirs)])];
  const merged = keys.map((key): [string, Value] => [key, mergedValue(base[key], mine[key], theirs[key], place ? `${place}.${key}` : key, conflicts)]);
  return Object.fromEntries(merged.filter(([, value]) => value !== undefined)) as Form;
}

function mergedValue(base: Value, mine: Value, theirs: Value, place: string, conflicts: string[]): Value {
  if (isSame(mine, theirs) || isSame(base, theirs)) return mine;
  if (isSame(base, mine)) return theirs;
  if (isForm(mine) && isForm(theirs)) return mergedFields(isForm(base) ? base : {}, mine, theirs, place, conflicts);
  if (hasNames(mine) && hasNames(theirs)) return mergedRows(hasNames(base) ? base : [], mine, theirs, place, conflicts);
  conflicts.push(place);
  return mine;
}

const hasNames = (value: Value): value is Form[] => Array.isArray(value) && value.every((row) => isForm(row) && typeof row.name === 'string');

function mergedRows(base: Form[], mine: Form[], theirs: Form[], place: string, conflicts: string[]): Form[] {
  const named = (rows: Form[], name: unknown) => rows.find((row) => row.name === name);
  const rows = [...mine, ...theirs.filter((row) => !named(mine, row.name))];
  return rows.flatMap((row) => {
    const [was, own, other] = [named(base, row.name), named(mine, row.name), named(theirs, row.name)];
    const at = `${place}.${typeof row.name === 'string' ? row.name : ''}`;
    const kept = mergedValue(was, own, other, at, conflicts);
    return kept === undefined ? [] : [kept as Form];
  });
}
