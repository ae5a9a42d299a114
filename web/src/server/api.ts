import type { Action, Connectable, Done, ExportForm, Files, Layout, Offers, TreeEvent } from '../model/types';
import { followStream, type StreamListener } from './stream';

/** An answer of the server that is no success; `message` is a sentence for people. */
export class ServerError extends Error {
  constructor(readonly kind: string, message: string) {
    super(message);
  }
}

/** Calls of the server: everything the page asks for beside the stream. */
export interface Api {
  /** Calls of rooms: each knows the shape of its answers. */
  get: <T>(path: string) => Promise<T>;
  post: <T>(path: string, body: object) => Promise<T>;
  /** Follows a stream of a room until the returned function is called. */
  follow: (path: string, listener: StreamListener) => () => void;
  /** An answer that is no JSON. */
  fetched: (path: string) => Promise<Response>;
  /** `shown` are the components to lay out, null for all; `at` is a past moment, null for the present. */
  layout: (folded: string[], shown: string[] | null, at: number | null) => Promise<Layout>;
  act: (actions: Action[], isDryRun: boolean) => Promise<Done>;
  connectable: (port: string) => Promise<Connectable[]>;
  events: () => Promise<TreeEvent[]>;
  offers: (manager: string) => Promise<Offers>;
  files: () => Promise<Files>;
  /** `at` is a past moment, null for the present. */
  exported: (form: ExportForm, at: number | null) => Promise<Blob>;
}

/** `page` is the id by which the server knows this page, and by which changes are told apart. */
export function createApi(token: string, page: string): Api {
  const headers = { Authorization: `Bearer ${token}`, 'Rtkit-Page': page };
  const get = <T>(path: string) => call<T>(path, { headers });
  const post = <T>(path: string, body: object) =>
    call<T>(path, { method: 'POST', headers: { ...headers, 'Content-Type': 'application/json' }, body: JSON.stringify(body) });
  return {
    get,
    post,
    follow: (path, listener) => followStream(token, path, listener),
    fetched: (path) => answered(path, { headers }),
    layout: (folded, shown, at) => post<Layout>('/api/layout', { folded, ...(shown && { shown }), ...(at !== null && { at }) }),
    act: (actions, isDryRun) => post<Done>('/api/do', { actions, dry_run: isDryRun }),
    connectable: async (port) => (await get<{ ports: Connectable[] }>(`/api/connectable?port=${encodeURIComponent(port)}`)).ports,
    offers: (manager) => get<Offers>(`/api/offers?manager=${encodeURIComponent(manager)}`),
    files: () => get<Files>('/api/files'),
    exported: async (form, at) => (await answered(`/api/export?form=${form}${at === null ? '' : `&at=${at}`}`, { headers })).blob(),
    events: async () => (await get<{ events: TreeEvent[] }>('/api/events?since=0')).events,
  };
}

const call = async <T>(path: string, init: RequestInit): Promise<T> => (await answered(path, init)).json() as Promise<T>;

/** The answer of a call that has done what it should; throws the server's sentence else. */
async function answered(path: string, init: RequestInit): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new ServerError('unreachable', 'The server does not answer.');
  }
  if (response.ok) return response;
  const body: unknown = await response.json().catch(() => null);
  const error = (body as { error?: { kind: string; text: string } } | null)?.error;
  throw new ServerError(error?.kind ?? 'failed', error?.text ?? `The server answers with status ${response.status}.`);
}

/** The sentence to show for anything that was thrown. */
export const sentence = (error: unknown): string => (error instanceof Error ? error.message : String(error));
