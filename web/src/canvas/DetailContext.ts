import { createContext } from 'react';

/** What boxes and wires show at the zoom of the diagram; those of one context only are drawn anew when it changes. */
export type BoxDetail = 'speck' | 'name' | 'all';
/** The width of the area in which a wire is picked [px of the diagram]. */
export interface WireDetail { hasLabel: boolean; area: number }

export const BoxDetailContext = createContext<BoxDetail>('all');
export const WireDetailContext = createContext<WireDetail>({ hasLabel: true, area: 24 });
