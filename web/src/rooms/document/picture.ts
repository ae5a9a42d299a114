import { EMPTY_SYSTEM, type System } from '../../model/system';
import type { Box, Layout, Look, PortPlace } from '../../model/types';
import type { Direction, DocumentComponent, Finding, Picture, Severity } from './types';

/** Words of the page for what a box tells of itself. */
export interface BoxWords { severity: Record<Severity, string>; untyped: string; required: string; optional: string; included: string }

const NO_PROFILE = 'no-profile';
/** Title and type of a box [px]. */
const HEADER = 42;

/** The findings that are about something, worst first. */
export function findingsOn(findings: readonly Finding[]): Map<string, Finding[]> {
  const found = new Map<string, Finding[]>();
  for (const finding of findings) if (finding.on) found.set(finding.on, [...(found.get(finding.on) ?? []), finding]);
  for (const list of found.values()) list.sort((one, other) => rank(one) - rank(other));
  return found;
}

const rank = ({ severity }: Finding): number => (['error', 'warning', 'note'] as const).indexOf(severity);

/** A document as a system that the diagram can draw: nothing runs, so what its boxes tell is what the checks say. */
export function systemOf(picture: Picture, words: BoxWords): System {
  const findings = findingsOn(picture.findings);
  const components = picture.components.map((one) => ({ ...one, ...told(one, findings.get(one.id) ?? [], words) }));
  const connectors = picture.connectors.map((one) => ({ ...one, trouble: troubleOf(findings.get(one.id) ?? []) }));
  return {
    ...EMPTY_SYSTEM, revision: picture.revision, isKnown: true,
    components: new Map(components.map((one) => [one.id, one])), connectors: new Map(connectors.map((one) => [one.id, one])),
  };
}

function told(component: DocumentComponent, findings: readonly Finding[], words: BoxWords): { look: Look; word: string; remark: string } {
  const standing = component.origin ? words.included : component.is_required ? words.required : words.optional;
  const worst = findings.find((one) => one.severity !== 'note' && one.rule !== NO_PROFILE);
  if (worst) return { look: worst.severity === 'error' ? 'error' : 'stuck', word: words.severity[worst.severity], remark: worst.text };
  if (findings.some((one) => one.rule === NO_PROFILE)) return { look: 'unknown', word: words.untyped, remark: '' };
  return { look: 'created', word: standing, remark: '' };
}

const troubleOf = (findings: readonly Finding[]): string => findings.find((one) => one.severity !== 'note')?.text ?? '';

/** The layout with the bend points of the profile, and with boxes turned as it says. */
export function layoutOf({ layout, bends, places, components, connectors }: Picture): Layout {
  const boxes = { ...layout.boxes };
  const turned = new Set<string>();
  for (const { id, ports } of components) {
    const [box, direction] = [boxes[id], places[id]?.direction ?? 'RIGHT'];
    if (!box || direction === 'RIGHT') continue;
    boxes[id] = turnedBox(box, direction, new Set(ports.filter((port) => port.direction === 'in').map((port) => port.name)));
    turned.add(id);
  }
  // The paths of the layout lead to ports at the left and the right.
  const lost = new Set(connectors.filter(({ source, target }) => turned.has(source.component) || turned.has(target.component)).map(({ id }) => id));
  const paths = Object.fromEntries(Object.entries(layout.paths).filter(([id]) => !lost.has(id)));
  return { ...layout, boxes, paths, bends };
}

const [PORT_WIDTH, PORT_ROW] = [72, 22];

/** A box whose out ports point to the left, down or up; in ports are at the other side. */
export function turnedBox(box: Box, direction: Direction, ins: ReadonlySet<string>): Box {
  const names = Object.keys(box.ports);
  if (direction === 'LEFT' || direction === 'RIGHT') {
    const other = { left: 'right', right: 'left', top: 'top', bottom: 'bottom' } as const;
    return direction === 'RIGHT' ? box : { ...box, ports: Object.fromEntries(Object.entries(box.ports).map(([name, place]) => [name, { ...place, side: other[place.side] }])) };
  }
  const [inSide, outSide] = direction === 'DOWN' ? ['top', 'bottom'] as const : ['bottom', 'top'] as const;
  const rows = [names.filter((name) => ins.has(name)), names.filter((name) => !ins.has(name))] as const;
  const width = Math.max(box.width, PORT_WIDTH * Math.max(rows[0].length, rows[1].length));
  const [top, bottom] = [rows[direction === 'DOWN' ? 0 : 1].length, rows[direction === 'DOWN' ? 1 : 0].length];
  const height = HEADER + (top ? PORT_ROW : 0) + (bottom ? PORT_ROW : 0);
  const placed = rows.flatMap((row, index) => row.map((name, at): [string, PortPlace] =>
    [name, { side: index === 0 ? inSide : outSide, y: 0, x: Math.round(((at + 0.5) * width) / row.length) }]));
  return { ...box, width, height, ports: Object.fromEntries(placed) };
}

export function countsOf(findings: readonly Finding[]): Record<Severity, number> {
  const counts = { error: 0, warning: 0, note: 0 };
  for (const { severity } of findings) counts[severity] += 1;
  return counts;
}

/** The id of what a picture has and the one before had not. */
export const fresh = (before: Picture, after: Picture): string | undefined => {
  const known = new Set(before.components.map((one) => one.id));
  return after.components.find((one) => !known.has(one.id))?.id;
};

/** The command that tells the same findings in a shell. */
export function checkCommand(file: string, folders: readonly string[]): string {
  const quoted = (text: string) => (/^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", `'"'"'`)}'`);
  return ['rtprofile check', ...folders.map((folder) => `--components ${quoted(folder)}`), quoted(file)].join(' ');
}
