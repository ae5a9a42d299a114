import { useCallback, useEffect, useRef, useState } from 'react';

import type { Api } from '../../server/api';
import { sentence } from '../../server/api';
import type { Subscriptions } from '../../server/subscriptions';
import { useEditor } from '../../shell/contexts';
import type { Service } from './tree';
import { readGui, type Gui, type Told } from './widgets';

const LOOK_MS = 5000;

/** The services that are there, looked at now and then while the page is seen. */
export function useServices(api: Api, structure: number): readonly Service[] {
  const [services, setServices] = useState<readonly Service[]>([]);
  useEffect(() => {
    let isWanted = true;
    const look = async () => {
      if (document.hidden) return;
      const found = await api.get<{ services: Service[] }>('/api/properties/services').catch(() => null);
      if (isWanted && found) setServices(found.services);
    };
    void look();
    const timer = setInterval(() => void look(), LOOK_MS);
    return () => {
      isWanted = false;
      clearInterval(timer);
    };
  }, [api, structure]);
  return services;
}

/** The names of the properties of owners, asked for once each. */
export function useNames(api: Api): { names: ReadonlyMap<string, readonly string[]>; load: (owner: string) => void } {
  const [names, setNames] = useState<ReadonlyMap<string, readonly string[]>>(new Map());
  const asked = useRef(new Set<string>());
  const load = useCallback((owner: string) => {
    if (asked.current.has(owner)) return;
    asked.current.add(owner);
    api.get<{ names: string[] }>(`/api/properties/names?of=${encodeURIComponent(owner)}`).then(
      (found) => setNames((before) => new Map([...before, [owner, found.names]])),
      () => asked.current.delete(owner),
    );
  }, [api]);
  return { names, load };
}

/** What is looked at: a property or service by its target, or the text of a page that was put together. */
export type Wanted = { of: string } | { layout: string };

interface Sent { text: string; quality: string; code: string; is_raw: boolean; why?: string }
type Taker = (name: string, text: string, told: Told) => void;

/** The values of what is looked at: the latest, whether or not it is drawn yet. */
export interface Values { forEach: (take: Taker) => void; listen: (take: Taker) => () => void }

function useValues(subscriptions: Subscriptions): Values {
  const [values] = useState(createValues);
  useEffect(() => subscriptions.listen('properties', (data) => values.take(data as Record<string, Sent>)), [subscriptions, values]);
  return values;
}

function createValues(): Values & { take: (sent: Record<string, Sent>) => void } {
  const known = new Map<string, Sent>();
  const tell = (take: Taker, name: string, { text, quality, code, is_raw: isRaw, why }: Sent) => take(name, text, { quality, code, isRaw, ...(why && { why }) });
  const takers = new Set<Taker>();
  return {
    take: (all) => {
      for (const [name, sent] of Object.entries(all)) {
        known.set(name, sent);
        takers.forEach((take) => tell(take, name, sent));
      }
    },
    forEach: (take) => known.forEach((sent, name) => tell(take, name, sent)),
    listen: (take) => {
      takers.add(take);
      return () => void takers.delete(take);
    },
  };
}

/** What is to be drawn, or why it cannot be; `why` tells that what is drawn may be old. */
export interface Page { gui: Gui | null; error: string; why: string }

const NO_PAGE: Page = { gui: null, error: '', why: '' };

/** A page that is put together stays one while it is changed: it is not drawn from nothing each time. */
const nameOf = (wanted: Wanted | null): string => (wanted && 'of' in wanted ? wanted.of : '');
const AGAIN_MS = 2000;

/** Has the server follow what is wanted as long as it is seen, and tells what is to be drawn. */
export function usePropertyPage(isUp: boolean, wanted: Wanted | null): Page & { values: Values } {
  const { api, subscriptions, values: { page } } = useEditor();
  const [shown, setShown] = useState({ ...NO_PAGE, name: '' });
  const values = useValues(subscriptions);
  // Requests follow each other: the server follows what was wanted last.
  const turn = useRef<Promise<void>>(Promise.resolve());
  const key = JSON.stringify(wanted);
  useEffect(() => {
    if (!isUp) return undefined;
    let isWanted = true;
    let again: ReturnType<typeof setTimeout> | undefined;
    const about = JSON.parse(key) as Wanted | null;
    const watch = async (what: Wanted | null) => {
      clearTimeout(again);
      try {
        const { gui } = await api.post<{ gui: string }>('/api/properties/watch', { page, ...what });
        if (isWanted && what) setShown({ gui: readGui(gui), error: '', why: '', name: nameOf(what) });
      } catch (error) {
        if (!isWanted) return;
        setShown((before) => ({ ...(before.name === nameOf(about) ? before : NO_PAGE), error: sentence(error), name: nameOf(about) }));
        again = setTimeout(ask, AGAIN_MS);
      }
    };
    const ask = () => {
      turn.current = turn.current.then(() => watch(isWanted && !document.hidden ? about : null));
    };
    const close = subscriptions.listen('outdated', (data) => {
      const { why } = data as { why: string };
      if (why) setShown((before) => ({ ...before, why }));
      else ask();
    });
    // A stream that has begun anew is looked at by nobody yet.
    const closePicture = subscriptions.listen('picture', ask);
    document.addEventListener('visibilitychange', ask);
    ask();
    return () => {
      isWanted = false;
      close();
      closePicture();
      document.removeEventListener('visibilitychange', ask);
      ask();
    };
  }, [api, subscriptions, page, isUp, key]);
  return { ...(shown.name === nameOf(wanted) ? shown : NO_PAGE), values };
}

