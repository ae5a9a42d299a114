import type { Api } from './api';

/** What the server tells of a port; `text` and `numbers` are of the last value, once one has come. */
export interface Sample {
  /** Values written to an out port, or read from an in port. */
  count: number;
  /** When the last value came [s since 1970]; null when none has. */
  at: number | null;
  text?: string;
  /** Its first numbers by field; null for one that is not finite. */
  numbers?: Record<string, number | null>;
  /** Of an in port, by connector: values that wait, how many fit, how many were dropped since somebody looks. */
  buffers?: Record<string, [waiting: number, length: number, dropped: number]>;
}

/** So long values are kept for plots [s]. */
export const KEPT_S = 60;
/** While boxes are moved through the window the set of ports changes all the time: one message for each pause. */
const PAUSE_MS = 120;

/** The values of the ports that the page shows: the server is told which, and sends no others. */
export interface Values {
  /** By this name the server knows the page. */
  page: string;
  /** Has `changed` called when a port has a new sample, until the returned function is called. */
  subscribe: (port: string, changed: () => void) => () => void;
  latest: (port: string) => Sample | undefined;
  /** The samples of the last minute in which a value came, oldest first. */
  kept: (port: string) => readonly Sample[];
  take: (samples: Record<string, Sample>) => void;
  /** The stream has begun anew: the server does not know what this page shows. */
  begin: () => void;
}

/** Nothing flows: for what was. */
export const NO_VALUES: Values = {
  page: '', subscribe: () => () => undefined, latest: () => undefined, kept: () => [], take: () => undefined, begin: () => undefined,
};

export function createValues(api: Pick<Api, 'post'>, page: string): Values {
  const listeners = new Map<string, Set<() => void>>();
  const latest = new Map<string, Sample>();
  const kept = new Map<string, Sample[]>();
  let timer: ReturnType<typeof setTimeout> | null = null;
  let isKnown = false;

  const take = (samples: Record<string, Sample>) => {
    for (const [port, sample] of Object.entries(samples)) {
      if (!listeners.has(port)) continue;
      const before = latest.get(port);
      latest.set(port, sample);
      if (sample.at !== null && sample.at !== before?.at) keep(kept, port, sample);
      listeners.get(port)?.forEach((changed) => changed());
    }
  };
  const send = () => {
    timer = null;
    if (!isKnown) return;
    // A page that is not known any more begins a new stream, which comes back to this.
    api.post<{ values: Record<string, Sample> }>('/api/watch', { page, ports: [...listeners.keys()] }).then(
      ({ values }) => take(values), () => { isKnown = false; },
    );
  };
  const plan = () => { timer ??= setTimeout(send, PAUSE_MS); };

  return {
    page, take,
    latest: (port) => latest.get(port),
    kept: (port) => kept.get(port) ?? [],
    begin: () => {
      isKnown = true;
      plan();
    },
    subscribe: (port, changed) => {
      const all = listeners.get(port) ?? new Set();
      if (!all.size) plan();
      listeners.set(port, all.add(changed));
      return () => {
        all.delete(changed);
        if (all.size) return;
        for (const map of [listeners, latest, kept]) map.delete(port);
        plan();
      };
    },
  };
}

function keep(kept: Map<string, Sample[]>, port: string, sample: Sample): void {
  const samples = kept.get(port) ?? [];
  const begin = (sample.at ?? 0) - KEPT_S;
  const first = samples.findIndex(({ at }) => (at ?? 0) >= begin);
  kept.set(port, [...(first < 0 ? [] : samples.slice(first)), sample]);
}
