import type { Api } from '../../server/api';
import type { Gui, Source } from './widgets';

/** A value that holds while somebody keeps it: what is set afterwards, and after which silence [s]. */
export interface Held { rest: string; after: number }

/** The properties behind the server, as widgets ask for them; `onSet` gets the command line of each SET. */
export function createSource(api: Api, page: string, isReadOnly: boolean, onSet: (command: string) => void): Source {
  const value = (target: string) => api.fetched(`/api/properties/value?target=${encodeURIComponent(target)}`);
  const text = async (target: string) => (await value(target)).text();
  return {
    isReadOnly,
    text,
    get: async (target, isRaw = false) => (isRaw ? (await value(target)).arrayBuffer() : text(target)),
    set: async (target, wanted, held) => {
      const given = held ? { page, ...held } : { page };
      const { command } = await api.post<{ command: string }>('/api/properties/set', { target, value: wanted, ...given });
      onSet(command);
    },
    component: ({ attributes: { html } }: Gui) => html === undefined ? undefined
      : async () => (await api.post<{ address: string }>('/api/properties/component', { target: html })).address,
  };
}
