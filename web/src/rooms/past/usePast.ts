import { useCallback, useEffect, useMemo, useRef, useState } from 'react';

import { pastOf, type Kept, type Past } from '../../model/past';
import type { System } from '../../model/system';
import type { Change } from '../../model/types';
import { sentence, type Api } from '../../server/api';
import type { Subscriptions } from '../../server/subscriptions';

/** The past that the page shows: the moment, and what was then; all null while it shows the present. */
export interface Shown {
  time: number | null;
  system: System | null;
  layoutAt: number | null;
  /** Times of all changes; empty until the past is loaded, which the first step into it does. */
  times: readonly number[];
  go: (time: number | null) => void;
  /** Loads the past, so that keys can step through it. */
  load: () => Promise<Past | null>;
}

const NO_TIMES: readonly number[] = [];

export function usePast(api: Api, subscriptions: Subscriptions, onError: (text: string) => void): Shown {
  const [past, setPast] = useState<Past | null>(null);
  const [time, setTime] = useState<number | null>(null);
  const loading = useRef<Promise<Past | null> | null>(null);
  const load = useCallback(() => {
    loading.current ??= api.get<Kept>('/api/past').then((kept) => {
      const loaded = pastOf(kept);
      setPast(loaded);
      return loaded;
    }, (error: unknown) => {
      loading.current = null;
      onError(sentence(error));
      return null;
    });
    return loading.current;
  }, [api, onError]);
  useEffect(() => {
    const ends = [
      subscriptions.listen('change', (data) => void loading.current?.then((loaded) => loaded?.add(data as Change))),
      // What is known reaches back further now; somebody may look at it already.
      subscriptions.listen('past', () => {
        const isLoaded = loading.current !== null;
        loading.current = null;
        if (isLoaded) void load();
      }),
      // The stream has begun anew: changes may be missing, and the server may be another one.
      subscriptions.listen('picture', () => {
        loading.current = null;
        setPast(null);
        setTime(null);
      }),
    ];
    return () => ends.forEach((end) => end());
  }, [subscriptions, load]);
  const go = useCallback((next: number | null) => {
    setTime(next);
    if (next !== null) void load();
  }, [load]);
  return useMemo(() => ({
    time, go, load, times: past?.times ?? NO_TIMES,
    system: past && time !== null ? past.at(time) : null,
    layoutAt: past && time !== null ? past.layoutAt(time) : null,
  }), [time, go, load, past]);
}
