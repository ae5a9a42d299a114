import { createContext, useContext } from 'react';

import { en, type Texts } from './en';
import { ja } from './ja';

export type { Texts } from './en';

export const LANGUAGES = { en, ja } as const;
export type Language = keyof typeof LANGUAGES;

const KEY = 'rtkit.language';

/** The language that was chosen, else that of the browser, else English. */
export function preferredLanguage(): Language {
  const chosen = localStorage.getItem(KEY) ?? navigator.language.slice(0, 2);
  return chosen === 'ja' ? 'ja' : 'en';
}

export const rememberLanguage = (language: Language): void => localStorage.setItem(KEY, language);

export const TextsContext = createContext<Texts>(en);
export const useTexts = (): Texts => useContext(TextsContext);

/** The texts of a room, which are loaded with it, in the language of the page. */
export const useRoomTexts = <T,>(catalogues: Record<Language, T>): T => catalogues[useTexts().key];
