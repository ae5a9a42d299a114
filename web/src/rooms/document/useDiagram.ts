import { useCallback, useEffect, useMemo, useRef, useState } from 'react';

import type { Connectable, Point } from '../../model/types';
import { useEditor } from '../../shell/contexts';
import type { Editor } from '../../shell/editor';
import { FIRST_VIEW, type View } from '../../shell/view';
import type { Place, Picture } from './types';
import type { OpenDocument } from './useDocument';

/** Nothing flows in a document. */
const NO_VALUES: Editor['values'] = {
  page: '', subscribe: () => () => undefined, latest: () => undefined, kept: () => [], take: () => undefined, begin: () => undefined,
};

interface Size { width: number; height: number }

/** Where boxes stand: by the profile, and as they are just dragged. */
function placedBy(picture: Picture | null, moved: ReadonlyMap<string, Place>, sized: ReadonlyMap<string, Size>): View['placed'] {
  const places = new Map<string, Place & Partial<Size>>(Object.entries(picture?.places ?? {}));
  for (const [id, at] of moved) places.set(id, { ...places.get(id), ...at });
  for (const [id, to] of sized) {
    const at = places.get(id) ?? picture?.layout.boxes[id];
    if (at) places.set(id, { x: at.x, y: at.y, ...to });
  }
  return places;
}

/** The view of a document's diagram, and an editor for the canvas that works on the document instead of what lives. */
export function useDiagram(document: OpenDocument): { view: View; editor: Editor; bends: ReadonlyMap<string, readonly Point[]> } {
  const outer = useEditor();
  const { picture, edit, fold } = document;
  const [selection, setSelection] = useState<readonly string[]>([]);
  const [folded, setFolded] = useState<ReadonlySet<string>>(new Set());
  const [moved, setMoved] = useState<ReadonlyMap<string, Place>>(new Map());
  const [sized, setSized] = useState<ReadonlyMap<string, Size>>(new Map());
  const [bends, setBends] = useState<ReadonlyMap<string, readonly Point[]>>(new Map());
  const size = useRef<[string, Size] | null>(null);
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
      if (size.current) {
        const [component, { width, height }] = size.current;
        size.current = null;
        void edit({ do: 'resize', component, width: Math.round(width), height: Math.round(height) }).then(() => setSized(new Map()));
      }
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

  const resize = useCallback((id: string, to: Size) => {
    const own = latest.current?.components.find((one) => one.id === id);
    if (!canChange || !own || own.origin) return;
    size.current = [id, to];
    setSized(new Map([[id, to]]));
  }, [canChange]);

  const bend = useCallback((id: string, points: readonly Point[], isOver: boolean) => {
    const own = latest.current?.connectors.find((one) => one.id === id);
    if (!canChange || !own || own.origin) return;
    setBends(new Map([[id, points]]));
    if (isOver) void edit({ do: 'bend', connector: id, points: points.map(([x, y]) => ({ x, y })) }).then(() => setBends(new Map()));
  }, [canChange, edit]);

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
    resize,
    bend,
  }), [outer, canChange, toggleFold, place, resize, bend]);

  const view = useMemo<View>(() => ({
    ...FIRST_VIEW, selection, folded, centre, placed: placedBy(picture, moved, sized),
  }), [selection, folded, centre, picture, moved, sized]);
  return { view, editor, bends };
}
