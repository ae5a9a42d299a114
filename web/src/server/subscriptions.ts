/** Takes the data of an event of the stream, as it was sent. */
export type Listener = (data: unknown) => void;

/** Hands events of the stream to the parts of the page that listen to their kind. */
export interface Subscriptions {
  notify: (kind: string, data: unknown) => void;
  /** Listens until the returned function is called. */
  listen: (kind: string, listener: Listener) => () => void;
}

export function createSubscriptions(): Subscriptions {
  const listeners = new Map<string, Set<Listener>>();
  return {
    notify: (kind, data) => listeners.get(kind)?.forEach((listener) => listener(data)),
    listen: (kind, listener) => {
      const all = listeners.get(kind) ?? new Set();
      listeners.set(kind, all.add(listener));
      return () => void all.delete(listener);
    },
  };
}
