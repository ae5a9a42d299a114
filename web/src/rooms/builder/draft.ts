import { useSyncExternalStore } from 'react';

import type { Form } from './form';

/** A component in the making. It lives as long as the tab does, also while another room is shown. */
export interface Draft {
  /** Tells drafts apart that follow each other. */
  id: number;
  form: Form;
  /** Where its files are to be; empty follows its name. */
  folder: string;
  /** The file that it was read from; empty for a new one. */
  origin: string;
  past: readonly Form[];
  future: readonly Form[];
  /** What the last edit was about: edits of the same field in a row are one step. */
  last: string;
  isChanged: boolean;
  /** The text of the profile in the folder as this draft knows it, and the form of then; null where it was not looked at yet. */
  base: string | null;
  baseForm: Form;
  /** Put beside the components that the folder has. */
  adds: boolean;
}

const KEY = 'rtkit.builder';
const MOST = 200;

let count = 0;

export const begun = (form: Form, origin: string, folder: string): Draft =>
  ({ id: (count += 1), form, folder, origin, past: [], future: [], last: '', isChanged: false, base: null, baseForm: form, adds: false });

export function edited(draft: Draft, form: Form, about: string): Draft {
  if (form === draft.form) return draft;
  const isSame = about !== '' && about === draft.last && draft.past.length > 0;
  const past = isSame ? draft.past : [...draft.past, draft.form].slice(-MOST);
  return { ...draft, form, past, future: [], last: about, isChanged: true };
}

export function undone(draft: Draft): Draft {
  const form = draft.past.at(-1);
  return form ? { ...draft, form, past: draft.past.slice(0, -1), future: [draft.form, ...draft.future], last: '', isChanged: true } : draft;
}

export function redone(draft: Draft): Draft {
  const [form, ...future] = draft.future;
  return form ? { ...draft, form, past: [...draft.past, draft.form], future, last: '', isChanged: true } : draft;
}

let present = restored();
const listeners = new Set<() => void>();

/** The draft after a reload of the page, without its history. */
function restored(): Draft | null {
  try {
    const kept = JSON.parse(sessionStorage.getItem(KEY) ?? 'null') as (Pick<Draft, 'form' | 'folder' | 'origin' | 'isChanged'> & Partial<Pick<Draft, 'base' | 'baseForm' | 'adds'>>) | null;
    return kept ? { ...begun(kept.form, kept.origin, kept.folder), isChanged: kept.isChanged, base: kept.base ?? null, baseForm: kept.baseForm ?? kept.form, adds: kept.adds ?? false } : null;
  } catch {
    return null; // another version of the page has left something else there
  }
}

export function changeDraft(change: (draft: Draft | null) => Draft | null): void {
  present = change(present);
  if (present) {
    const { form, folder, origin, isChanged, base, baseForm, adds } = present;
    sessionStorage.setItem(KEY, JSON.stringify({ form, folder, origin, isChanged, base, baseForm, adds }));
  } else sessionStorage.removeItem(KEY);
  for (const listen of listeners) listen();
}

const subscribe = (listen: () => void): (() => void) => {
  listeners.add(listen);
  return () => listeners.delete(listen);
};

export const presentDraft = (): Draft | null => present;

export const useDraft = (): Draft | null => useSyncExternalStore(subscribe, presentDraft);
