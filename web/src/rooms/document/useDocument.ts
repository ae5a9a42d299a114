import { useCallback, useEffect, useMemo, useRef, useState } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useRoomTexts } from '../../texts';
import { documentTexts as en } from '../../texts/en/document';
import { documentTexts as ja } from '../../texts/ja/document';
import type { Edit, Picture } from './types';

export const useDocumentTexts = () => useRoomTexts({ en, ja });

/** The address of a document without a file begins with this. */
export const UNSAVED = '#';

/** One document: its latest picture, and what changes it. Each function returns the new picture, null when it was refused. */
export interface OpenDocument {
  picture: Picture | null;
  problem: string;
  /** What was done last, for readers of the screen. */
  done: string;
  isClosed: boolean;
  /** Texts with variables that the last edit would replace; it waits until `answer` tells whether it may. */
  asks: readonly string[] | null;
  answer: (may: boolean) => void;
  edit: (edit: Edit) => Promise<Picture | null>;
  move: (way: 'undo' | 'redo') => Promise<Picture | null>;
  /** Throws when it is refused: the dialog tells why. */
  save: (file: string, replace: boolean) => Promise<Picture>;
  fold: (folded: readonly string[]) => void;
  clear: () => void;
}

interface Question { asks: readonly string[]; decide: (may: boolean) => void }

export function useDocument(of: string): OpenDocument {
  const texts = useDocumentTexts();
  const { api, subscriptions } = useEditor();
  const [picture, setPicture] = useState<Picture | null>(null);
  const [problem, setProblem] = useState('');
  const [done, setDone] = useState('');
  const [isClosed, setClosed] = useState(false);
  const folded = useRef<readonly string[]>([]);
  const latest = useRef<Picture | null>(null);
  const asking = useRef(0);
  const newest = useRef(0);

  const take = useCallback((next: Picture) => {
    // Answers of two requests may come in the other order; an edit of another page may be newer.
    if (latest.current && next.id === latest.current.id && next.revision < latest.current.revision) return latest.current;
    latest.current = next;
    setPicture(next);
    return next;
  }, []);

  const [question, setQuestion] = useState<Question | null>(null);
  const exchange = useCallback(async (path: string, body: object): Promise<Picture> => {
    asking.current += 1;
    try {
      const answer = await api.post<Picture | { asks: string[] }>(path, { ...body, folded: folded.current });
      if (!('asks' in answer)) return take(answer);
      const may = await new Promise<boolean>((decide) => setQuestion({ asks: answer.asks, decide }));
      setQuestion(null);
      if (!may) throw new Error(texts.keptVariables);
      return take(await api.post<Picture>(path, { ...body, replaces_variables: true, folded: folded.current }));
    } finally {
      asking.current -= 1;
    }
  }, [api, take, texts]);

  /** Takes what other pages did. An edit of this page comes by its answer alone, so that it is shown and selected at once. */
  const catchUp = useCallback(function again() {
    const known = latest.current;
    if (!known || asking.current || newest.current <= known.revision) return;
    newest.current = 0;
    exchange(`/api/documents/${known.id}`, {}).then(again, (error: unknown) => setProblem(sentence(error)));
  }, [exchange]);

  const ask = useCallback((path: string, body: object) => exchange(path, body).finally(catchUp), [exchange, catchUp]);

  useEffect(() => {
    let isWanted = true;
    const first = of.startsWith(UNSAVED) ? ask(`/api/documents/${encodeURIComponent(of.slice(1))}`, {}) : ask('/api/documents/open', { file: of });
    first.catch((error: unknown) => isWanted && setProblem(sentence(error)));
    return () => {
      isWanted = false;
    };
  }, [ask, of]);

  useEffect(() => subscriptions.listen('document', (data) => {
    const news = data as { id: string; revision: number | null };
    const known = latest.current;
    if (news.id !== known?.id) return;
    if (news.revision === null) setClosed(true);
    else {
      newest.current = Math.max(newest.current, news.revision);
      catchUp();
    }
  }), [subscriptions, catchUp]);

  const attempt = useCallback(async (path: string, body: object, said: (before: Picture, after: Picture) => string) => {
    const before = latest.current;
    if (!before) return null;
    try {
      const after = await ask(`/api/documents/${before.id}/${path}`, body);
      setProblem('');
      setDone(said(before, after));
      return after;
    } catch (error) {
      setProblem(sentence(error));
      return null;
    }
  }, [ask]);

  return useMemo<OpenDocument>(() => ({
    picture, problem, done, isClosed,
    asks: question?.asks ?? null,
    answer: (may) => question?.decide(may),
    edit: (edit) => attempt('edit', { edit }, (_, after) => texts.did(after.undo ?? '')),
    move: (way) => attempt('move', { way }, (before) => (way === 'undo' ? texts.undoOf(before.undo ?? '') : texts.redoOf(before.redo ?? ''))),
    save: async (file, replace) => {
      const after = await ask(`/api/documents/${latest.current?.id ?? ''}/save`, { file, replace });
      setProblem('');
      setDone(texts.saved(after.file));
      return after;
    },
    fold: (next) => {
      folded.current = next;
      if (latest.current) ask(`/api/documents/${latest.current.id}`, {}).catch((error: unknown) => setProblem(sentence(error)));
    },
    clear: () => setProblem(''),
  }), [picture, problem, done, isClosed, question, attempt, ask, texts]);
}
