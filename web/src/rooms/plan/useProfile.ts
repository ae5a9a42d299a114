import { useEffect, useState } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { Profile } from './types';

/** What a profile says; nothing for no file. A further `look` reads it anew. */
export function useProfile(file: string, look = 0): { profile: Profile | null; problem: string } {
  const { api } = useEditor();
  const [found, setFound] = useState<{ profile: Profile | null; problem: string }>({ profile: null, problem: '' });
  useEffect(() => {
    if (!file) return undefined;
    let isWanted = true;
    api.get<Profile>(`/api/plans/profile?file=${encodeURIComponent(file)}`).then(
      (profile) => isWanted && setFound({ profile, problem: '' }),
      (error: unknown) => isWanted && setFound({ profile: null, problem: sentence(error) }),
    );
    return () => {
      isWanted = false;
    };
  }, [api, file, look]);
  return found;
}
