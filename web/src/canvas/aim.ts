interface Point { x: number; y: number }

/** The wire at a point of the window, which is `at` in the diagram: of those whose areas lie there the nearest; null where there is none. */
export function wireAt({ clientX, clientY }: { clientX: number; clientY: number }, at: Point): Element | null {
  let [found, least]: [Element | null, number] = [null, Infinity];
  for (const each of document.elementsFromPoint(clientX, clientY)) {
    if (!(each instanceof SVGPathElement) || !each.matches('.react-flow__edge-interaction')) continue;
    const distance = distanceTo(each, at);
    if (distance < least) [found, least] = [each.closest('.react-flow__edge'), distance];
  }
  return found;
}

/** How finely a wire is looked along [px of the diagram]. */
const STEP = 2;
const MOST_STEPS = 2000;

function distanceTo(path: SVGPathElement, { x, y }: Point): number {
  const length = path.getTotalLength();
  const count = Math.min(Math.max(Math.ceil(length / STEP), 1), MOST_STEPS);
  let least = Infinity;
  for (let index = 0; index <= count; index += 1) {
    const point = path.getPointAtLength((length * index) / count);
    least = Math.min(least, Math.hypot(point.x - x, point.y - y));
  }
  return least;
}
