import { useCallback, useLayoutEffect, useRef } from 'react';

/** A function that stays the same between renderings and does what the latest one does: for events only, never while rendering. */
export function useStable<Given extends unknown[], Result>(does: (...given: Given) => Result): (...given: Given) => Result {
  const latest = useRef(does);
  useLayoutEffect(() => {
    latest.current = does;
  });
  return useCallback((...given: Given) => latest.current(...given), []);
}
