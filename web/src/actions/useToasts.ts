import { useCallback, useMemo, useState } from 'react';

export interface Toast {
  id: number; level: 'done' | 'info' | 'warning' | 'error'; title: string; lines: string[];
  /** What does the same in a shell; empty when nothing was done. */
  command: string;
  canUndo: boolean;
  /** Takes what was refused off the list of what can be undone. */
  onDrop?: () => void;
}

export interface Toasts { list: readonly Toast[]; add: (toast: Omit<Toast, 'id'>) => void; close: (id: number) => void }

let lastId = 0;

export function useToasts(): Toasts {
  const [list, setList] = useState<readonly Toast[]>([]);
  const add = useCallback((toast: Omit<Toast, 'id'>) => {
    lastId += 1;
    const fresh = { ...toast, id: lastId };
    // Good news replaces older good news, so that "Undo" on it always means the last action; errors pile up until closed.
    setList((before) => [...before.filter((one) => one.level === 'error' || one.level === 'warning'), fresh]);
  }, []);
  const close = useCallback((id: number) => setList((before) => before.filter((one) => one.id !== id)), []);
  return useMemo(() => ({ list, add, close }), [list, add, close]);
}
