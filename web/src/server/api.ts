import type { Action, Connectable, Done, Layout, TreeEvent } from '../model/types';

/** An answer of the server that is no success; `message` is a sentence for people. */
export class ServerError extends Error {
  constructor(readonly kind: string, message: string) {
    super(message);
  }
}

/** Calls of the server: everything the page asks for beside the stream. */
export interface Api {
  layout: (folded: string[]) => Promise<Layout>;
  act: (actions: Action[], isDryRun: boolean) => Promise<Done>;
  connectable: (port: string) => Promise<Connectable[]>;
  events: () => Promise<TreeEvent[]>;
}

export function createApi(token: string): Api {
  const headers = { Authorization: `Bearer ${token}` };
  const get = <T>(path: string) => call<T>(path, { headers });
  const post = <T>(path: string, body: object) =>
    call<T>(path, { method: 'POST', headers: { ...headers, 'Content-Type': 'application/json' }, body: JSON.stringify(body) });
  return {
    layout: (folded) => post<Layout>('/api/layout', { folded }),
    act: (actions, isDryRun) => post<Done>('/api/do', { actions, dry_run: isDryRun }),
    connectable: async (port) => (await get<{ ports: Connectable[] }>(`/api/connectable?port=${encodeURIComponent(port)}`)).ports,
    events: async () => (await get<{ events: TreeEvent[] }>('/api/events?since=0')).events,
  };
}

async function call<T>(path: string, init: RequestInit): Promise<T> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new ServerError('unreachable', 'The server does not answer.');
  }
  const body: unknown = await response.json().catch(() => null);
  if (response.ok) return body as T;
  const error = (body as { error?: { kind: string; text: string } } | null)?.error;
  throw new ServerError(error?.kind ?? 'failed', error?.text ?? `The server answers with status ${response.status}.`);
}

/** The sentence to show for anything that was thrown. */
export const sentence = (error: unknown): string => (error instanceof Error ? error.message : String(error));
