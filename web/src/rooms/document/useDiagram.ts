import { useCallback, useEffect, useMemo, useRef, useState } from 'react';

import type { Connectable } from '../../model/types';
import { useEditor } from '../../shell/contexts';
import type { Editor } from '../../shell/editor';
import { FIRST_VIEW, type View } from '../../shell/view';
import type { Place, Picture } from './types';
import type { OpenDocument } from './useDocument';

/** Nothing flows in a document. */
const NO_VALUES: Editor['values'] = {
  page: '', subscribe: () => () => undefined, latest: () => undefined, kept: () => [], take: () => undefined, begin: () => undefined,
};

/** The view of a document's diagram, and an editor for the canvas that works on the document instead of what lives. */
export function useDiagram(document: OpenDocument): { view: View; editor: Editor } {
  const outer = useEditor();
  const { picture, edit, fold } = document;
  const [selection, setSelection] = useState<readonly string[]>([]);
  const [folded, setFolded] = useState<ReadonlySet<string>>(new Set());
  const [moved, setMoved] = useState<ReadonlyMap<string, Place>>(new Map());
  const [centre, setCentre] = useState<View['centre']>(null);
  const pending = useRef<ReadonlyMap<string, Place>>(new Map());
  const latest = useRef<Picture | null>(null);
  const canChange = outer.canChange && !document.isClosed;
  useEffect(() => {
    latest.current = picture;
  }, [picture]);

  // A drag is one edit: it is sent when the button or the key is let go.
  useEffect(() => {
    const commit = () => {
      const places = pending.current;
      if (!places.size) return;
      pending.current = new Map();
      void edit({ do: 'move', places: Object.fromEntries(places) }).then(() => {
        if (!pending.current.size) setMoved(new Map());
      });
    };
    addEventListener('pointerup', commit);
    addEventListener('keyup', commit);
    return () => {
      removeEventListener('pointerup', commit);
      removeEventListener('keyup', commit);
    };
  }, [edit]);

  const place = useCallback((places: ReadonlyMap<string, Place>) => {
    const own = new Map([...places].filter(([id]) => latest.current?.components.some((one) => one.id === id && !one.origin)));
    if (!canChange || !own.size) return;
    pending.current = new Map([...pending.current, ...own]);
    setMoved((before) => new Map([...before, ...own]));
  }, [canChange]);

  const toggleFold = useCallback((id: string) => {
    const next = new Set(folded);
    if (!next.delete(id)) next.add(id);
    setFolded(next);
    fold([...next]);
  }, [folded, fold]);

  const editor = useMemo<Editor>(() => ({
    ...outer,
    canChange,
    values: NO_VALUES,
    api: {
      ...outer.api,
      connectable: async (port) => (await outer.api.get<{ ports: Connectable[] }>(`/api/documents/${latest.current?.id ?? ''}/fitting?port=${encodeURIComponent(port)}`)).ports,
    },
    select: setSelection,
    reveal: (id) => {
      setSelection([id]);
      setCentre((before) => ({ id, count: (before?.count ?? 0) + 1 }));
    },
    toggleFold,
    place,
  }), [outer, canChange, toggleFold, place]);

  const view = useMemo<View>(() => ({
    ...FIRST_VIEW, selection, folded, centre, placed: new Map([...Object.entries(picture?.places ?? {}), ...moved]),
  }), [selection, folded, centre, picture?.places, moved]);
  return { view, editor };
}
