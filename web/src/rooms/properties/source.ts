import type { Api } from '../../server/api';
import type { Action } from '../../model/types';
import type { Gui, Source } from './widgets';

/** How a SET went: its command line, and what takes it back, or why nothing does; `change` is one number for a value that is being moved. */
export interface SetDone { target: string; command: string; undo: Action[] | null; undo_reason: string; change: number }

/** A value that holds while somebody keeps it: what is set afterwards, and after which silence [s]. */
export interface Held { rest: string; after: number }

/** The properties behind the server, as widgets ask for them; `onSet` is told each SET. */
export function createSource(api: Api, page: string, isReadOnly: boolean, onSet: (done: SetDone) => void): Source {
  const value = (target: string) => api.fetched(`/api/properties/value?target=${encodeURIComponent(target)}`);
  const text = async (target: string) => (await value(target)).text();
  return {
    isReadOnly,
    text,
    get: async (target, isRaw = false) => (isRaw ? (await value(target)).arrayBuffer() : text(target)),
    set: async (target, wanted, held) => {
      const given = held ? { page, ...held } : { page };
      const done = await api.post<Omit<SetDone, 'target'>>('/api/properties/set', { target, value: wanted, ...given });
      onSet({ target, ...done });
    },
    component: ({ attributes: { html } }: Gui) => html === undefined ? undefined
      : async () => (await api.post<{ address: string }>('/api/properties/component', { target: html })).address,
  };
}
