import { useEffect, type Dispatch } from 'react';

import { addressOf, fragmentOf } from './address';
import type { View, ViewEvent } from './view';

/** Keeps the address as the view is, and the view as an address that is typed or pasted later. */
export function useAddress(view: View, dispatch: Dispatch<ViewEvent>): void {
  const fragment = fragmentOf(view);
  useEffect(() => {
    history.replaceState(null, '', location.pathname + location.search + (fragment ? `#${fragment}` : ''));
  }, [fragment]);
  useEffect(() => {
    const go = () => dispatch({ kind: 'address', address: addressOf(location.hash) });
    addEventListener('hashchange', go);
    return () => removeEventListener('hashchange', go);
  }, [dispatch]);
}
