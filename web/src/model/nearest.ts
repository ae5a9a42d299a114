import type { Box } from './types';

type Place = Pick<Box, 'x' | 'y' | 'width' | 'height'>;

export type Heading = 'ArrowLeft' | 'ArrowRight' | 'ArrowUp' | 'ArrowDown';

export const isHeading = (key: string): key is Heading =>
  key === 'ArrowLeft' || key === 'ArrowRight' || key === 'ArrowUp' || key === 'ArrowDown';

/** The box that an arrow key goes to: the nearest one whose middle lies that way; null at the edge. */
export function nearest(boxes: ReadonlyMap<string, Place>, from: string, heading: Heading): string | null {
  const start = boxes.get(from);
  if (!start) return null;
  const [x, y] = middle(start);
  let best: string | null = null;
  let least = Infinity;
  for (const [id, box] of boxes) {
    const [dx, dy] = [middle(box)[0] - x, middle(box)[1] - y];
    const along = { ArrowLeft: -dx, ArrowRight: dx, ArrowUp: -dy, ArrowDown: dy }[heading];
    const across = Math.abs(heading === 'ArrowLeft' || heading === 'ArrowRight' ? dy : dx);
    // What lies straight ahead is nearer than what lies as far, but aside.
    const distance = along + 2 * across;
    if (id !== from && along > 1 && distance < least) [best, least] = [id, distance];
  }
  return best;
}

const middle = (box: Place): [number, number] => [box.x + box.width / 2, box.y + box.height / 2];
