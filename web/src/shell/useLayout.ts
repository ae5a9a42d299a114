import { useEffect, useState } from 'react';

import type { Layout } from '../model/types';
import { sentence, type Api } from '../server/api';

/** Changes of the structure come in bursts, while a system is deployed: one layout for each pause. */
const PAUSE_MS = 60;

/** The layout for this structure and these folded boxes, of the present or as it was at a moment; the one before until the next has come. */
export function useLayout(
  api: Api, structure: number, folded: ReadonlySet<string>, shown: ReadonlySet<string> | null, at: number | null, onError: (text: string) => void,
): Layout | null {
  const [layout, setLayout] = useState<Layout | null>(null);
  useEffect(() => {
    if (!structure) return undefined;
    let isWanted = true;
    const timer = setTimeout(() => {
      api.layout([...folded], shown && [...shown], at).then(
        (next) => isWanted && setLayout(next),
        (error: unknown) => isWanted && onError(sentence(error)),
      );
    }, PAUSE_MS);
    return () => {
      isWanted = false;
      clearTimeout(timer);
    };
  }, [api, structure, folded, shown, at, onError]);
  return layout;
}
