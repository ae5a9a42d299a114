/** The wire at a point of the window: of those whose areas lie there the nearest; null where there is none. */
export function wireAt(x: number, y: number): Element | null {
  let [found, least]: [Element | null, number] = [null, Infinity];
  for (const each of document.elementsFromPoint(x, y)) {
    if (!(each instanceof SVGPathElement) || !each.matches('.react-flow__edge-interaction')) continue;
    const distance = distanceTo(each, x, y);
    if (distance < least) [found, least] = [each.closest('.react-flow__edge'), distance];
  }
  return found;
}

/** How finely a wire is looked along [px of the diagram]. */
const STEP = 2;
const MOST_STEPS = 2000;

function distanceTo(path: SVGPathElement, x: number, y: number): number {
  const matrix = path.getScreenCTM();
  if (!matrix) return Infinity;
  const point = new DOMPoint(x, y).matrixTransform(matrix.inverse());
  const length = path.getTotalLength();
  const count = Math.min(Math.max(Math.ceil(length / STEP), 1), MOST_STEPS);
  let least = Infinity;
  for (let index = 0; index <= count; index += 1) {
    const at = path.getPointAtLength((length * index) / count);
    least = Math.min(least, Math.hypot(at.x - point.x, at.y - point.y));
  }
  return least;
}
