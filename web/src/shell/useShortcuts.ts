import { useEffect, useLayoutEffect, useRef } from 'react';

/** True where keys belong to a field or a dialog. */
export function isTyping(event: KeyboardEvent): boolean {
  const at = event.target instanceof Element ? event.target : null;
  return Boolean(at?.closest('input, select, textarea, dialog, [contenteditable]'));
}

/** True where Ctrl-Z takes back what was typed; a slider or a check box has no such thing. */
function isText(event: KeyboardEvent): boolean {
  const at = event.target instanceof Element ? event.target : null;
  return !at?.matches('input:is([type=range], [type=checkbox], [type=radio])') && isTyping(event);
}

type Name = 'palette' | 'keys' | 'undo' | 'redo' | 'remove' | 'connect' | 'clear' | 'turn' | 'all';
/** What keys do; one without a function is left to others. */
export type Shortcuts = Partial<Record<Name, () => void>>;

/** Keys that hold everywhere in the page, but not while one types. */
export function useShortcuts(shortcuts: Shortcuts): void {
  const latest = useRef(shortcuts);
  // Before the page is shown: a key is about what is seen.
  useLayoutEffect(() => {
    latest.current = shortcuts;
  });
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      const name = shortcutOf(event);
      const go = name && latest.current[name];
      if (!go) return;
      event.preventDefault();
      go();
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  }, []);
}

function shortcutOf(event: KeyboardEvent): Name | null {
  if (document.querySelector('dialog[open]')) return null;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const isControl = event.ctrlKey || event.metaKey;
  if (isControl && key === 'k') return 'palette';
  if (isText(event)) return null;
  if (isControl && key === 'z') return event.shiftKey ? 'redo' : 'undo';
  if (isControl && key === 'y') return 'redo';
  if (isTyping(event)) return null;
  if (isControl && key === 'a') return 'all';
  if (isControl || event.altKey) return null;
  const plain: Record<string, Name> = {
    '/': 'palette', '?': 'keys', c: 'connect', t: 'turn', Delete: 'remove', Backspace: 'remove', Escape: 'clear',
  };
  return plain[key] ?? null;
}
