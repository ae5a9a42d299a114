import { useEffect, useReducer, useState } from 'react';

import type { AuditRecord } from '../../model/types';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';

/** As many as the server keeps. */
const KEPT = 2000;

/** Puts records to those that are known, or forgets all for null; of a record that came before, the later takes its place. */
export function joinedChanges(known: readonly AuditRecord[], news: readonly AuditRecord[] | null): readonly AuditRecord[] {
  if (news === null) return [];
  const all = new Map(known.map((one) => [one.id, one]));
  for (const one of news) {
    const before = all.get(one.id);
    if (!before || before.count <= one.count) all.set(one.id, one);
  }
  return [...all.values()].sort((one, other) => one.id - other.id).slice(-KEPT);
}

/** What was changed since the server began, as far as it keeps that, and what is changed from now on. */
export function useChanges(): { changes: readonly AuditRecord[]; error: string } {
  const { api, subscriptions } = useEditor();
  const [changes, take] = useReducer(joinedChanges, []);
  const [error, setError] = useState('');
  useEffect(() => {
    let isWanted = true;
    const load = () => {
      // After a break the stream may be that of another server, whose numbers begin anew.
      take(null);
      api.get<{ changes: AuditRecord[] }>('/api/changes').then((kept) => isWanted && take(kept.changes), (failure: unknown) => isWanted && setError(sentence(failure)));
    };
    const closes = [subscriptions.listen('changed', (data) => take([data as AuditRecord])), subscriptions.listen('picture', load)];
    load();
    return () => {
      isWanted = false;
      closes.forEach((close) => close());
    };
  }, [api, subscriptions]);
  return { changes, error };
}
