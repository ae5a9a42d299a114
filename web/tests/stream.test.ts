import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';

import { SILENCE_MS, openStream, waitBefore, type Link } from '../src/server/stream';

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

/** A server whose answers the test writes by hand. */
function server() {
  const bodies: ReadableStreamDefaultController<Uint8Array>[] = [];
  const fetcher = vi.fn((_path: unknown, init?: RequestInit) => {
    const body = new ReadableStream<Uint8Array>({
      start(controller) {
        bodies.push(controller);
        init?.signal?.addEventListener('abort', () => controller.error(new DOMException('', 'AbortError')));
      },
    });
    return Promise.resolve(new Response(body));
  });
  return { bodies, fetcher };
}

function watch(fetcher: typeof fetch) {
  const links: Link[] = [];
  const events: string[] = [];
  const close = openStream('secret', 'mine', { onLink: (link) => links.push(link), onEvent: ({ data }) => events.push(data) }, fetcher);
  return { links, events, close };
}

const settle = () => vi.advanceTimersByTimeAsync(0);
const say = (text: string) => new TextEncoder().encode(text);

describe('the connection', () => {
  it('sends the token in a header, never in the address', async () => {
    const { fetcher } = server();
    const { close } = watch(fetcher);
    expect(fetcher.mock.calls[0]?.[0]).toBe('/api/stream?page=mine');
    expect(fetcher.mock.calls[0]?.[1]?.headers).toMatchObject({ Authorization: 'Bearer secret' });
    await settle();
    close();
  });

  it('hands events on and connects again when the stream ends', async () => {
    const { bodies, fetcher } = server();
    const { links, events, close } = watch(fetcher);
    await settle();
    bodies[0]?.enqueue(say('data: one\n\n'));
    await settle();
    bodies[0]?.close();
    await vi.advanceTimersByTimeAsync(waitBefore(0));
    expect(fetcher).toHaveBeenCalledTimes(2);
    expect(events).toEqual(['one']);
    expect(links).toEqual(['connecting', 'up', 'lost', 'up']);
    close();
  });

  it('counts a silent server as lost', async () => {
    const { fetcher } = server();
    const { links, close } = watch(fetcher);
    await vi.advanceTimersByTimeAsync(SILENCE_MS);
    expect(links.at(-1)).toBe('lost');
    close();
  });

  it('is kept up by comment lines', async () => {
    const { bodies, fetcher } = server();
    const { links, close } = watch(fetcher);
    for (let passed = 0; passed < 3 * SILENCE_MS; passed += 5000) {
      await vi.advanceTimersByTimeAsync(5000);
      bodies[0]?.enqueue(say(': alive\n\n'));
    }
    await settle();
    expect(links).toEqual(['connecting', 'up']);
    close();
  });

  it('waits longer after each failure, at most 5 s', () => {
    expect([0, 1, 2, 3, 4, 20].map(waitBefore)).toEqual([500, 1000, 2000, 4000, 5000, 5000]);
  });

  it('does not ask again with a token that is wrong', async () => {
    const fetcher = vi.fn(() => Promise.resolve(new Response('', { status: 401 })));
    const { links } = watch(fetcher);
    await vi.advanceTimersByTimeAsync(60_000);
    expect(fetcher).toHaveBeenCalledOnce();
    expect(links.at(-1)).toBe('denied');
  });
});
