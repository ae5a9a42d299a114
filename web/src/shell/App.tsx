import { useCallback, useEffect, useMemo, useState } from 'react';

import { dropToken, findToken, keepToken, shareToken } from '../server/token';
import { LANGUAGES, TextsContext, preferredLanguage, rememberLanguage, type Language } from '../texts';
import { EditorPage } from './EditorPage';
import { Locked } from './Locked';
import type { Settings } from './TopBar';
import { preferredTheme, rememberTheme } from './theme';

/** The page: finds the token, then shows the editor in the language and colours that were chosen. */
export function App() {
  const [token, setToken] = useState<string | null>(null);
  const [isRefused, setRefused] = useState(false);
  const [theme, setTheme] = useState(preferredTheme);
  const [language, setLanguage] = useState<Language>(preferredLanguage);
  useEffect(() => {
    void findToken().then(setToken);
    return shareToken();
  }, []);
  useEffect(() => {
    document.documentElement.lang = language;
  }, [language]);
  const settings = useMemo<Settings>(() => ({
    theme,
    setTheme: (next) => { rememberTheme(next); setTheme(next); },
    language,
    setLanguage: (next) => { rememberLanguage(next); setLanguage(next); },
  }), [theme, language]);
  const accept = (next: string) => {
    keepToken(next);
    setToken(next);
  };
  const refuse = useCallback(() => {
    dropToken();
    setRefused(true);
    setToken('');
  }, []);
  return (
    <TextsContext value={LANGUAGES[language]}>
      {token === '' && <Locked isRefused={isRefused} onToken={accept} />}
      {token && <EditorPage key={token} token={token} settings={settings} onDenied={refuse} />}
    </TextsContext>
  );
}
