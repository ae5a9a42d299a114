import { useEffect, useReducer, useState } from 'react';

import type { JobNews, JobRow } from '../../model/types';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';

/** Rows of a job, the number of the first of them, and why they are not known. */
export interface JobRows { first: number; rows: readonly JobRow[]; error: string }

/** As many as the server keeps. */
const ROWS_KEPT = 10_000;

const NO_ROWS: JobRows = { first: 0, rows: [], error: '' };

/** Puts rows behind those that are known; rows that came by both ways count once. */
export function joined(known: JobRows, news: Pick<JobNews, 'first' | 'rows'>): JobRows {
  const { first = 0, rows = [] } = news;
  const next = known.first + known.rows.length;
  if (!rows.length || first + rows.length <= next) return known;
  if (!known.rows.length || first > next) return { ...known, first, rows };
  const all = [...known.rows, ...rows.slice(next - first)];
  const dropped = Math.max(all.length - ROWS_KEPT, 0);
  return { ...known, first: known.first + dropped, rows: all.slice(dropped) };
}

/** The rows that a job has told, and those that it tells from now on. */
export function useJobRows(id: string): JobRows {
  const { api, subscriptions } = useEditor();
  const [told, take] = useReducer(joined, NO_ROWS);
  const [error, setError] = useState('');
  useEffect(() => {
    let isWanted = true;
    // What comes while the kept rows are asked for waits: rows are put together in their order.
    let waiting: JobNews[] | null = [];
    const close = subscriptions.listen('job', (data) => {
      const news = data as JobNews;
      if (news.id !== id || !news.rows) return;
      if (waiting) waiting.push(news);
      else take(news);
    });
    api.get<JobNews>(`/api/jobs/${encodeURIComponent(id)}`).then((kept) => {
      if (!isWanted) return;
      [kept, ...(waiting ?? [])].forEach(take);
      waiting = null;
    }, (failure: unknown) => isWanted && setError(sentence(failure)));
    return () => {
      isWanted = false;
      close();
    };
  }, [api, subscriptions, id]);
  return error ? { ...told, error } : told;
}
