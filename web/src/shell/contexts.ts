import { createContext, useContext } from 'react';

import type { Rates } from '../model/types';
import type { Editor } from './editor';

/** What every part of the page may ask of the editor. Its functions stay the same between renderings. */
export const EditorContext = createContext<Editor | null>(null);

export function useEditor(): Editor {
  const editor = useContext(EditorContext);
  if (!editor) throw new Error('useEditor is used outside of the editor');
  return editor;
}

/** Rates come each second; only what shows one listens, so that the rest is not drawn anew. */
export const RatesContext = createContext<Rates>({ connectors: {}, components: {} });
