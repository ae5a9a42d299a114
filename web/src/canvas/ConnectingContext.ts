import { createContext } from 'react';

import type { PortEnd } from '../model/types';

/** A wire that is being drawn: where it began, and why each port takes it or not (empty: it does). */
export interface Connecting {
  from: PortEnd;
  /** By the paths of ports; null until the server has answered. */
  whys: ReadonlyMap<string, string> | null;
}

export const ConnectingContext = createContext<Connecting | null>(null);
