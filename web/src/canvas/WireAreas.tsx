import { useStore } from '@xyflow/react';
import { useEffect, type RefObject } from 'react';

/** What a finger needs to hit a wire [px of the window]. */
const TARGET = 24;
/** Farther away wires are not picked by hand. */
const LEAST_ZOOM = 0.2;

/** Gives wires an area that a finger hits at any zoom; it changes in steps, for a new one costs a look at all wires. */
export function WireAreas({ of }: { of: RefObject<HTMLElement | null> }) {
  const step = useStore(({ transform }) => Math.floor(2 * Math.log2(Math.max(transform[2], LEAST_ZOOM))));
  useEffect(() => of.current?.style.setProperty('--wire-area', `${TARGET / 2 ** (step / 2)}px`), [of, step]);
  return null;
}
