import type { Point } from '../model/types';

const RADIUS = 6;

/** The path of SVG through right-angled points, with rounded corners. */
export function roundedPath(points: readonly Point[]): string {
  const [first, ...rest] = points;
  if (!first) return '';
  let path = `M${first[0]},${first[1]}`;
  rest.forEach((corner, index) => {
    const before = points[index] ?? corner;
    const after = rest[index + 1];
    if (!after) {
      path += `L${corner[0]},${corner[1]}`;
      return;
    }
    const radius = Math.min(RADIUS, distance(before, corner) / 2, distance(corner, after) / 2);
    const [inX, inY] = towards(corner, before, radius);
    const [outX, outY] = towards(corner, after, radius);
    path += `L${inX},${inY}Q${corner[0]},${corner[1]} ${outX},${outY}`;
  });
  return path;
}

/** The middle of the longest level piece, the best place for a label, and how long that is. */
export function labelPlace(points: readonly Point[]): [x: number, y: number, length: number] {
  let best: Point = points[0] ?? [0, 0];
  let longest = -1;
  for (let index = 1; index < points.length; index += 1) {
    const [[x1, y1], [x2, y2]] = [points[index - 1] ?? best, points[index] ?? best];
    const length = y1 === y2 ? Math.abs(x2 - x1) : -0.5;
    if (length > longest) [best, longest] = [[(x1 + x2) / 2, (y1 + y2) / 2], length];
  }
  return [...best, Math.max(longest, 0)];
}

const distance = ([x1, y1]: Point, [x2, y2]: Point): number => Math.hypot(x2 - x1, y2 - y1);

function towards([x, y]: Point, to: Point, length: number): Point {
  const all = distance([x, y], to) || 1;
  return [x + ((to[0] - x) * length) / all, y + ((to[1] - y) * length) / all];
}
