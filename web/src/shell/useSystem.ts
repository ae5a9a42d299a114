import { useEffect, useReducer, useState } from 'react';

import { EMPTY_SYSTEM, reduceSystem, type System } from '../model/system';
import type { Change, JobNews, Notice, Picture, Rates } from '../model/types';
import { sentence, type Api } from '../server/api';
import type { Subscriptions } from '../server/subscriptions';
import { openStream, type Link } from '../server/stream';
import type { Sample, Values } from '../server/values';

interface Watched { system: System; link: Link; lostAt: number }

/** The system as the server tells it, and how the connection stands. */
export function useSystem(token: string, api: Api, subscriptions: Subscriptions, values: Values, onNotice: (notice: Notice) => void): Watched {
  const [system, dispatch] = useReducer(reduceSystem, EMPTY_SYSTEM);
  const [{ link, lostAt }, setLink] = useState<{ link: Link; lostAt: number }>({ link: 'connecting', lostAt: 0 });
  useEffect(() => {
    const close = openStream(token, values.page, {
      onLink: (next) => setLink((before) => ({
        link: next,
        lostAt: next === 'lost' && before.link !== 'lost' ? Date.now() / 1000 : before.lostAt,
      })),
      onEvent: ({ event, data }) => {
        const record: unknown = JSON.parse(data);
        if (event === 'picture') dispatch({ kind: 'picture', picture: record as Picture });
        else if (event === 'change') dispatch({ kind: 'change', change: record as Change });
        else if (event === 'rates') dispatch({ kind: 'rates', rates: record as Rates });
        else if (event === 'job') dispatch({ kind: 'job', news: record as JobNews });
        else if (event === 'past') dispatch({ kind: 'past', since: (record as { since: number }).since });
        else if (event === 'notice') onNotice(record as Notice);
        if (event === 'values') values.take((record as { values: Record<string, Sample> }).values);
        if (event === 'picture') values.begin();
        subscriptions.notify(event, record);
      },
    });
    return close;
  }, [token, subscriptions, values, onNotice]);
  useEffect(() => {
    // The stream tells what happens from now on; what happened before is a call of its own.
    const load = () => void api.events().then(
      (events) => dispatch({ kind: 'events', events }),
      (error: unknown) => onNotice({ level: 'warning', text: sentence(error) }),
    );
    load();
    return subscriptions.listen('past', load);
  }, [api, subscriptions, onNotice]);
  return { system, link, lostAt };
}
