import { useEffect, useState } from 'react';

import { sentence, type Api } from '../../server/api';
import type { Finding, Form } from './form';

/** What would become of a file: its text as it is, as generated, and with the changes of both where they fit together. */
export interface FilePreview {
  path: string; name: string; fate: 'written' | 'unchanged' | 'kept' | 'conflict'; why: string | null; line: number;
  before: string | null; after: string; merged: string | null;
}
/** The file that a component's profile becomes: beside others it bears the name of the component. */
export const profileFile = (files: readonly FilePreview[], name: string): FilePreview | undefined =>
  files.find((file) => file.name === `${name}.xml`) ?? files.find((file) => file.name === 'RTC.xml');
/** What becomes of a file. Of a conflict nothing is left when the file has all that is new already. */
export const fateOf = ({ fate, before, merged }: FilePreview): FilePreview['fate'] => (fate === 'conflict' && merged !== null && merged === before ? 'kept' : fate);

export interface Preview {
  findings: Finding[]; xml: string; files: FilePreview[]; notes: string[];
  module: { path: string; init: string; type: string } | null;
}
export interface Opened { form: Form; xml: string; notes: string[] }
export interface BuilderOffers { folders: string[]; files: string[]; types: string[] }
export type Choice = 'keep' | 'replace' | 'merge';
export interface Written { text: string; command: string; ok: boolean; error: string; output: string }

export const offersOf = (api: Api) => api.get<BuilderOffers>('/api/builder');
export const newForm = (api: Api, name: string) => api.post<Opened>('/api/builder/new', { name });
export const openFile = (api: Api, file: string) => api.post<Opened>('/api/builder/open', { file });
export const openText = (api: Api, name: string, text: string) => api.post<Opened>('/api/builder/open', { name, text });
export const writeFiles = (api: Api, form: Form, folder: string, choices: Record<string, Choice>, adds: boolean) =>
  api.post<Written>('/api/builder/write', { form, folder, choices, adds });
/** The command line that would write the files. */
export const commandOf = async (api: Api, form: Form, folder: string, choices: Record<string, Choice>, adds: boolean) =>
  (await api.post<Written>('/api/builder/write', { form, folder, choices, adds, dry_run: true })).command;
export const exportedText = async (api: Api, form: Form, kind: string) => (await api.post<{ text: string }>('/api/builder/export', { form, kind })).text;

/** A short pause in typing, after which the preview is asked for [ms]. */
const PAUSE_MS = 250;

/** `files` are the last that could be generated: an error in the form does not take them from sight. */
export interface PreviewState { preview: Preview | null; files: readonly FilePreview[]; isStale: boolean; error: string; /** The folder that was looked at. */ folder: string }

/** What would be generated from a form, asked for again when typing pauses; `count` asks anew. */
export function usePreview(api: Api, form: Form | null, folder: string, adds: boolean, count: number): PreviewState {
  const [state, setState] = useState<PreviewState & { of: Form | null }>({ preview: null, files: [], isStale: false, error: '', of: null, folder: '' });
  useEffect(() => {
    if (!form) return;
    let isWanted = true;
    const timer = setTimeout(() => {
      api.post<Preview>('/api/builder/preview', { form, folder, adds }).then(
        (preview) => isWanted && setState((before) => ({ preview, files: preview.files.length ? preview.files : before.files, isStale: false, error: '', of: form, folder })),
        (error: unknown) => isWanted && setState((before) => ({ ...before, error: sentence(error), of: form })),
      );
    }, PAUSE_MS);
    return () => {
      isWanted = false;
      clearTimeout(timer);
    };
  }, [api, form, folder, adds, count]);
  return { preview: form ? state.preview : null, files: state.files, isStale: state.of !== form, error: state.error, folder: state.folder };
}

export function download(text: string, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([text], { type: 'text/plain' }));
  link.download = name;
  link.click();
  // The browser reads the blob after the click has returned.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
