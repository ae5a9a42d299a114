import { useEffect, useRef } from 'react';

/** True where keys belong to a field or a dialog. */
export function isTyping(event: KeyboardEvent): boolean {
  const at = event.target instanceof Element ? event.target : null;
  return Boolean(at?.closest('input, select, textarea, dialog, [contenteditable]'));
}

export interface Shortcuts {
  palette: () => void; keys: () => void; undo: () => void; redo: () => void; remove: () => void; connect: () => void; clear: () => void; turn: () => void;
}

/** Keys that hold everywhere in the page, but not while one types. */
export function useShortcuts(shortcuts: Shortcuts): void {
  const latest = useRef(shortcuts);
  useEffect(() => {
    latest.current = shortcuts;
  });
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      const name = shortcutOf(event);
      if (!name) return;
      event.preventDefault();
      latest.current[name]();
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  }, []);
}

function shortcutOf(event: KeyboardEvent): keyof Shortcuts | null {
  if (document.querySelector('dialog[open]')) return null;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const isControl = event.ctrlKey || event.metaKey;
  if (isControl && key === 'k') return 'palette';
  if (isTyping(event)) return null;
  if (isControl && key === 'z') return event.shiftKey ? 'redo' : 'undo';
  if (isControl && key === 'y') return 'redo';
  if (isControl || event.altKey) return null;
  const plain: Record<string, keyof Shortcuts> = {
    '/': 'palette', '?': 'keys', c: 'connect', t: 'turn', Delete: 'remove', Backspace: 'remove', Escape: 'clear',
  };
  return plain[key] ?? null;
}
