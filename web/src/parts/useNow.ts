import { useSyncExternalStore } from 'react';

/** One clock for the page: hundreds of wires may ask it. */
const listeners = new Set<() => void>();
let now = Date.now() / 1000;
let timer: ReturnType<typeof setInterval> | null = null;

function subscribe(changed: () => void): () => void {
  listeners.add(changed);
  timer ??= setInterval(() => {
    now = Date.now() / 1000;
    listeners.forEach((each) => each());
  }, 1000);
  return () => {
    listeners.delete(changed);
    if (listeners.size || timer === null) return;
    clearInterval(timer);
    timer = null;
  };
}

function read(): number {
  // Nobody has listened for a while: the clock stands.
  if (timer === null) now = Date.now() / 1000;
  return now;
}

/** The time [s since 1970], new each second. */
export const useNow = (): number => useSyncExternalStore(subscribe, read);
