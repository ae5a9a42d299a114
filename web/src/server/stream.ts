import { EventStreamParser, type ServerEvent } from './sse';

/** The server says something at least every 5 s; after this silence the connection counts as lost. */
export const SILENCE_MS = 12_000;

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 5_000;

export type Link = 'connecting' | 'up' | 'lost' | 'denied';

export interface StreamListener {
  onEvent: (event: ServerEvent) => void;
  onLink: (link: Link) => void;
}

/** Waits before the next attempt: 0.5 s, 1 s, 2 s, 4 s, then 5 s. */
export const waitBefore = (attempt: number): number => Math.min(FIRST_WAIT_MS * 2 ** attempt, LONGEST_WAIT_MS);

/** Reads the event stream and connects again by itself until the returned function is called. */
export const openStream = (token: string, page: string, listener: StreamListener, fetcher: typeof fetch = fetch): (() => void) =>
  followStream(token, `/api/stream?page=${page}`, listener, fetcher);

/** The same with any stream of the server: a room may have its own. */
export function followStream(token: string, path: string, listener: StreamListener, fetcher: typeof fetch = fetch): () => void {
  const closing = new AbortController();
  void keepReading({ token, path }, listener, fetcher, closing.signal);
  return () => closing.abort();
}

/** Who reads what: its right to, and the address. */
interface Reader { token: string; path: string }

async function keepReading(reader: Reader, listener: StreamListener, fetcher: typeof fetch, closing: AbortSignal) {
  listener.onLink('connecting');
  for (let attempt = 0; !closing.aborted; attempt += 1) {
    const end = await readOnce(reader, fetcher, closing, (event) => {
      attempt = 0;
      listener.onEvent(event);
    }, () => listener.onLink('up'));
    if (end === 'closed') return;
    listener.onLink(end);
    if (end === 'denied') return;
    await pause(waitBefore(attempt), closing);
  }
}

async function readOnce(
  { token, path }: Reader, fetcher: typeof fetch, closing: AbortSignal,
  onEvent: (event: ServerEvent) => void, onUp: () => void,
): Promise<'denied' | 'lost' | 'closed'> {
  const attempt = new AbortController();
  const abort = () => attempt.abort();
  closing.addEventListener('abort', abort);
  let watchdog = setTimeout(abort, SILENCE_MS);
  try {
    const response = await fetcher(path, {
      headers: { Authorization: `Bearer ${token}`, Accept: 'text/event-stream' },
      cache: 'no-store',
      signal: attempt.signal,
    });
    if (response.status === 401 || response.status === 403) return 'denied';
    if (!response.ok || !response.body) return 'lost';
    onUp();
    const parser = new EventStreamParser();
    const pieces = response.body.getReader();
    for (;;) {
      const { done, value } = await pieces.read();
      if (done) return 'lost';
      clearTimeout(watchdog);
      watchdog = setTimeout(abort, SILENCE_MS);
      parser.feed(value).forEach(onEvent);
    }
  } catch (error) {
    // A connection that cannot be made or breaks is what this function is for; anything else is a fault of the page.
    if (error instanceof TypeError || (error instanceof DOMException && error.name === 'AbortError')) return closing.aborted ? 'closed' : 'lost';
    throw error;
  } finally {
    clearTimeout(watchdog);
    closing.removeEventListener('abort', abort);
    abort();
  }
}

function pause(milliseconds: number, closing: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, milliseconds);
    closing.addEventListener('abort', () => {
      clearTimeout(timer);
      resolve();
    }, { once: true });
  });
}
