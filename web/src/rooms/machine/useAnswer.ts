import { useEffect, useState } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { DraftAnswer, MachineRecord } from './types';

export interface Answered { machine: MachineRecord; answer: DraftAnswer }

/** What the server says to a draft: where it is drawn, what is wrong, its text. The last answer stays until the next one. */
export function useAnswer(machine: MachineRecord | undefined): { answered: Answered | null; error: string } {
  const { api } = useEditor();
  const [answered, setAnswered] = useState<Answered | null>(null);
  const [error, setError] = useState('');
  useEffect(() => {
    if (!machine) return undefined;
    let isWanted = true;
    api.post<DraftAnswer>('/api/machine/draft', { machine }).then(
      (answer) => {
        if (!isWanted) return;
        setAnswered({ machine, answer });
        setError('');
      },
      (failure: unknown) => isWanted && setError(sentence(failure)),
    );
    return () => {
      isWanted = false;
    };
  }, [api, machine]);
  return { answered, error };
}
