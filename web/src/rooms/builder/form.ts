/** The JSON form of an RTC profile, as the server reads and tells it. A place is a path in it: `dataPorts.1.name`. */
export type Value = string | number | boolean | null | Form | Value[] | undefined;
export interface Form { [key: string]: Value }

export interface Finding { place: string; level: 'error' | 'warning'; text: string }

export const DOC = 'rtcDoc::doc';
export const WIDGET = '__widget__';
/** The state that leads to the first one, by an event without name: so the profiles of other tools tell the beginning. */
export const INITIAL = 'InitialState';

export const isForm = (value: Value): value is Form => typeof value === 'object' && value !== null && !Array.isArray(value);

export function valueAt(form: Form, place: string): Value {
  let at: Value = form;
  for (const key of place.split('.')) {
    if (Array.isArray(at)) at = at[Number(key)];
    else if (isForm(at)) at = at[key];
    else return undefined;
  }
  return at;
}

export const textAt = (form: Form, place: string): string => {
  const value = valueAt(form, place);
  return typeof value === 'string' || typeof value === 'number' ? String(value) : '';
};

export const rowsAt = (form: Form, place: string): Form[] => {
  const value = valueAt(form, place);
  return Array.isArray(value) ? value.filter(isForm) : [];
};

/** The form with another value at a place; parts on the way are made, and those that become empty are left out. */
export const withValue = (form: Form, place: string, value: Value): Form => changed(form, place.split('.'), value) as Form;

function changed(at: Value, [key, ...rest]: string[], value: Value): Value {
  if (key === undefined) return value;
  if (Array.isArray(at)) return at.map((each, index) => (index === Number(key) ? changed(each, rest, value) : each));
  const before = isForm(at) ? at : {};
  const inner = changed(before[key], rest, value);
  const isNothing = inner === undefined || (isForm(inner) && !Object.keys(inner).length && isForm(before[key]));
  return isNothing ? Object.fromEntries(Object.entries(before).filter(([name]) => name !== key)) : { ...before, [key]: inner };
}

export const withRow = (form: Form, place: string, row: Value): Form => withValue(form, place, [...listAt(form, place), row]);

export const withoutRow = (form: Form, place: string, index: number): Form => {
  const rows = listAt(form, place).filter((_, at) => at !== index);
  return withValue(form, place, rows.length ? rows : undefined);
};

/** The form with a row moved by one place; as it is where there is none to change with. */
export function withMovedRow(form: Form, place: string, index: number, by: -1 | 1): Form {
  const rows = [...listAt(form, place)];
  const other = index + by;
  if (other < 0 || other >= rows.length) return form;
  [rows[index], rows[other]] = [rows[other], rows[index]];
  return withValue(form, place, rows);
}

const listAt = (form: Form, place: string): Value[] => {
  const value = valueAt(form, place);
  return Array.isArray(value) ? value : [];
};

const PROPERTIES = 'rtcExt::properties';

/** The value of an extension property of a part. */
export const propertyAt = (form: Form, place: string, name: string): string =>
  textAt(rowsAt(form, `${place}.${PROPERTIES}`).find((each) => each.name === name) ?? {}, 'value');

export function withProperty(form: Form, place: string, name: string, value: string): Form {
  const others = rowsAt(form, `${place}.${PROPERTIES}`).filter((each) => each.name !== name);
  const rows = value ? [...others, { name, value }] : others;
  return withValue(form, `${place}.${PROPERTIES}`, rows.length ? rows : undefined);
}

/** A name that no other part has: the first of `out`, `out2`, `out3` … that is free. */
export function freeName(taken: readonly string[], name: string): string {
  let free = name;
  for (let number = 2; taken.includes(free); number += 1) free = `${name}${number}`;
  return free;
}

/** Names of all ports: they share one space of names, whatever their kinds. */
export const portNames = (form: Form): string[] =>
  [...rowsAt(form, 'dataPorts'), ...rowsAt(form, 'servicePorts')].map((each) => textAt(each, 'name'));

/** Findings at a place or below it. */
export const findingsBelow = (findings: readonly Finding[], ...places: string[]): Finding[] =>
  findings.filter(({ place }) => places.some((each) => place === each || place.startsWith(`${each}.`)));

/** The folder that holds a file. */
export const folderOf = (file: string): string => file.slice(0, Math.max(0, file.lastIndexOf('/')));
