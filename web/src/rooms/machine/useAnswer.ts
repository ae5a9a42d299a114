import { useEffect, useRef, useState } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { DraftAnswer, MachineRecord } from './types';

export interface Answered { machine: MachineRecord; answer: DraftAnswer }

/**
 * What the server says to a draft: where it is drawn, what is wrong, its text. The last answer stays until the next one.
 * One draft is asked about at a time, then the newest: a large machine takes longer than one types.
 */
export function useAnswer(machine: MachineRecord | undefined): { answered: Answered | null; error: string } {
  const { api } = useEditor();
  const [answered, setAnswered] = useState<Answered | null>(null);
  const [error, setError] = useState('');
  const wanted = useRef(machine);
  const isAsking = useRef(false);
  useEffect(() => {
    const ask = async () => {
      for (let asked: MachineRecord | undefined; asked !== wanted.current;) {
        asked = wanted.current;
        try {
          const answer = await api.post<DraftAnswer>('/api/machine/draft', { machine: asked });
          setAnswered({ machine: asked as MachineRecord, answer });
          setError('');
        } catch (failure) {
          setError(sentence(failure));
        }
      }
      isAsking.current = false;
    };
    wanted.current = machine;
    if (!machine || isAsking.current) return;
    isAsking.current = true;
    void ask();
  }, [api, machine]);
  return { answered, error };
}
