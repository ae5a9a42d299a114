import { useState } from 'react';

import { useTexts } from '../texts';

/** Asks for the token, when neither the address nor another tab has one that the server takes. */
export function Locked({ isRefused, onToken }: { isRefused: boolean; onToken: (token: string) => void }) {
  const texts = useTexts();
  const [text, setText] = useState('');
  const token = /token=([^&\s]+)/.exec(text)?.[1] ?? text.trim();
  return (
    <main className="locked">
      <form onSubmit={(event) => { event.preventDefault(); if (token) onToken(token); }}>
        <h1><img src="/icon.svg" alt="" width="28" height="28" />{texts.locked.title}</h1>
        {isRefused && <p className="error" role="alert">{texts.locked.refused}</p>}
        <p>{texts.locked.body}</p>
        <label>{texts.locked.field} <input type="password" autoComplete="off" value={text} onChange={(event) => setText(event.target.value)} /></label>
        <button type="submit" className="primary" disabled={!token}>{texts.locked.open}</button>
      </form>
    </main>
  );
}
