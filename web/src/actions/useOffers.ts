import { useEffect, useState } from 'react';

import type { Offers } from '../model/types';
import { sentence } from '../server/api';
import { useEditor } from '../shell/contexts';

/** What a manager can make; the sentence why that is not known; null until it has answered. */
export function useOffers(manager: string): Offers | string | null {
  const { api } = useEditor();
  const [answer, setAnswer] = useState<Offers | string | null>(null);
  useEffect(() => {
    let isWanted = true;
    api.offers(manager).then(
      (offers) => isWanted && setAnswer(offers),
      (error: unknown) => isWanted && setAnswer(sentence(error)),
    );
    return () => {
      isWanted = false;
    };
  }, [api, manager]);
  return answer;
}
