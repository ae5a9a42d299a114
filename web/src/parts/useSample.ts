import { useCallback, useSyncExternalStore } from 'react';

import type { Sample } from '../server/values';
import { useEditor } from '../shell/contexts';

/** The latest sample of a port, as long as somebody shows it; undefined until one has come. */
export function useSample(port: string): Sample | undefined {
  const { values } = useEditor();
  const subscribe = useCallback((changed: () => void) => (port ? values.subscribe(port, changed) : () => undefined), [values, port]);
  return useSyncExternalStore(subscribe, () => values.latest(port));
}
