import type { Point } from '../model/types';

/** The bend points with one moved, or with a new one before it. */
export function withPoint(bends: readonly Point[], index: number, point: Point, isNew: boolean): Point[] {
  return isNew ? [...bends.slice(0, index), point, ...bends.slice(index)] : bends.map((one, number) => (number === index ? point : one));
}

/** The middles of the pieces of a wire: where a new bend point can be taken. */
export function between(points: readonly Point[]): Point[] {
  return points.slice(1).map(([x, y], index) => {
    const [x0, y0] = points[index] ?? [x, y];
    return [Math.round((x0 + x) / 2), Math.round((y0 + y) / 2)];
  });
}
