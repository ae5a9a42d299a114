import { useEffect, useState } from 'react';

import { Icon } from '../parts/icons';
import { useTexts } from '../texts';
import type { Toast, Toasts } from './useToasts';

/** Good news goes by itself after this time, unless the pointer or the focus is on it; errors stay until closed. */
const SHOWN_MS = 9_000;

export function ToastList({ toasts, onUndo }: { toasts: Toasts; onUndo: () => void }) {
  const texts = useTexts();
  return (
    <section className="toasts" aria-label={texts.toast.region}>
      {toasts.list.map((toast) => (
        <ToastCard key={toast.id} toast={toast} onClose={() => toasts.close(toast.id)} onUndo={onUndo} />
      ))}
    </section>
  );
}

function ToastCard({ toast, onClose, onUndo }: { toast: Toast; onClose: () => void; onUndo: () => void }) {
  const texts = useTexts();
  const [isHeld, setHeld] = useState(false);
  const [isCopied, setCopied] = useState(false);
  const stays = toast.level === 'error' || isHeld;
  useEffect(() => {
    if (stays) return undefined;
    const timer = setTimeout(onClose, SHOWN_MS);
    return () => clearTimeout(timer);
  });
  const copy = () => {
    void navigator.clipboard.writeText(toast.command).then(() => setCopied(true));
  };
  const hold = { onPointerEnter: () => setHeld(true), onPointerLeave: () => setHeld(false), onFocus: () => setHeld(true), onBlur: () => setHeld(false) };
  return (
    <div className={`toast toast-${toast.level}`} role={toast.level === 'error' ? 'alert' : 'status'} {...hold}>
      <p className="toast-title">{toast.title}</p>
      {toast.lines.map((line) => <p key={line}>{line}</p>)}
      {toast.command && <pre title={toast.command}><code>{toast.command}</code></pre>}
      {(toast.command || toast.onDrop) && (
        <div className="buttons">
          {toast.command && <button type="button" onClick={copy}><Icon name="copy" />{isCopied ? texts.toast.copied : texts.toast.copy}</button>}
          {toast.onDrop && <button type="button" onClick={() => { toast.onDrop?.(); onClose(); }}>{texts.toast.drop}</button>}
          {toast.canUndo && <button type="button" onClick={() => { onUndo(); onClose(); }}><Icon name="undo" />{texts.toast.undo}</button>}
        </div>
      )}
      <button type="button" className="quiet close" aria-label={texts.toast.close} title={texts.toast.close} onClick={onClose}><Icon name="close" /></button>
    </div>
  );
}
