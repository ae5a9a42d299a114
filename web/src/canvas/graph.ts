import { Position, type Edge, type Node, type NodeHandle } from '@xyflow/react';

import { endText } from '../model/does';
import { placedPorts } from '../model/ports';
import { lackingAt } from '../model/rights';
import type { System } from '../model/system';
import { LOOKS, portPath, type Box, type Component, type Connector, type Layout, type Look, type Manager, type Point, type Port, type PortEnd, type Process, type Side } from '../model/types';

const PAD = '24px';
/** The map and these buttons lie below what is fitted, not on it. */
export const FIT = { padding: { top: PAD, left: PAD, right: PAD, bottom: '124px' }, maxZoom: 1 } as const;
const HEADER = 42;
const HANDLE = 10;

export type ComponentNodeType = Node<{ component: Component; box: Box; connected: string }, 'component'>;

export interface Frame {
  kind: Exclude<Box['kind'], 'component'>; name: string; isFolded: boolean;
  /** The state of the manager, process or composite; its trouble in words. */
  state: string; isTroubled: boolean; why: string; counts: Count[];
}
export type FrameNodeType = Node<{ frame: Frame; box: Box; composite: Component | null }, 'frame'>;
export type WireEdgeType = Edge<{ wire: Connector; path: Point[] | null; bends: Point[] | null; lane: Lane; isNear: boolean }, 'wire'>;

/** How far a wire is led beside those that would lie on it: where it turns between its boxes, and at its ports [px]. */
export interface Lane { between: number; atPort: number }
export type GraphNode = ComponentNodeType | FrameNodeType;

export const POSITIONS: Readonly<Record<Side, Position>> = { left: Position.Left, right: Position.Right, top: Position.Top, bottom: Position.Bottom };

export type Count = [look: Look, count: number];
/** Where boxes stand by hand; a size is the least that a box has. */
export type Places = ReadonlyMap<string, { x: number; y: number; width?: number; height?: number }>;

/** A function that returns the object it made before while what it is made of is the same: React then skips it. */
export function keeper<T>(): (id: string, parts: readonly unknown[], make: () => T) => T {
  const kept = new Map<string, { parts: readonly unknown[]; value: T }>();
  return (id, parts, make) => {
    const old = kept.get(id);
    if (old && old.parts.length === parts.length && old.parts.every((part, index) => part === parts[index])) return old.value;
    const value = make();
    kept.set(id, { parts, value });
    return value;
  };
}

/** A function that returns the list it returned before while its members are the same: React Flow then looks at none of them. */
export function listKeeper<T>(): (list: T[]) => T[] {
  let kept: T[] = [];
  return (list) => {
    if (list.length !== kept.length || list.some((one, index) => one !== kept[index])) kept = list;
    return kept;
  };
}

/** The boxes as they stand: those of the layout, moved by hand, frames grown round what was moved. */
export function placedBoxes(layout: Layout, placed: Places): Map<string, Box> {
  const boxes = new Map<string, Box>();
  for (const [id, box] of Object.entries(layout.boxes)) {
    const place = placed.get(id);
    boxes.set(id, place && (box.kind === 'component' || box.is_folded) ? movedBox(box, place) : box);
  }
  if (placed.size) for (const [id, box] of boxes) if (placed.has(id)) growAround(boxes, box);
  return boxes;
}

function movedBox(box: Box, { x, y, width = 0, height = 0 }: { x: number; y: number; width?: number; height?: number }): Box {
  const wider = Math.max(width - box.width, 0);
  const taller = Math.max(height - box.height, 0);
  return { ...box, x, y, width: box.width + wider, height: box.height + taller };
}

const MARGIN = 16;

function growAround(boxes: Map<string, Box>, inner: Box): void {
  const outer = inner.parent === null ? undefined : boxes.get(inner.parent);
  if (!outer || inner.parent === null) return;
  const left = Math.min(outer.x, inner.x - MARGIN);
  const top = Math.min(outer.y, inner.y - HEADER);
  const right = Math.max(outer.x + outer.width, inner.x + inner.width + MARGIN);
  const bottom = Math.max(outer.y + outer.height, inner.y + inner.height + MARGIN);
  if (left === outer.x && top === outer.y && right === outer.x + outer.width && bottom === outer.y + outer.height) return;
  const grown = { ...outer, x: left, y: top, width: right - left, height: bottom - top };
  boxes.set(inner.parent, grown);
  growAround(boxes, grown);
}

/** The box that shows a component: its own, else the folded one round it; undefined when none does. */
export function shownAs(id: string, system: Pick<System, 'components'>, boxes: ReadonlyMap<string, Box>): string | undefined {
  for (let one = system.components.get(id); one; one = system.components.get(one.composite)) {
    if (boxes.has(one.id)) return one.id;
    if (!one.composite) return [one.process, one.manager].find((outer) => boxes.has(outer));
  }
  return undefined;
}

/** How many components below a manager, process or composite have each look. */
export function countsIn(components: Iterable<Component>): Count[] {
  const counts = new Map<Look, number>();
  for (const { look } of components) counts.set(look, (counts.get(look) ?? 0) + 1);
  return LOOKS.flatMap((look) => (counts.has(look) ? [[look, counts.get(look) ?? 0] as Count] : []));
}

interface Scene { system: System; boxes: ReadonlyMap<string, Box>; selection: ReadonlySet<string> }

/** What readers hear of a component. */
export type Label = (name: string, type: string, state: string, ports: number) => string;

export function buildNodes({ system, boxes, selection }: Scene, label: Label, keep: ReturnType<typeof keeper<GraphNode>>): GraphNode[] {
  const connected = connectedPorts(system.connectors.values());
  const nodes: GraphNode[] = [];
  for (const [id, box] of boxes) {
    const isSelected = selection.has(id);
    const component = system.components.get(id);
    if (box.kind === 'component') {
      if (!component) continue;
      const ports = (connected.get(id) ?? []).sort().join('\n');
      const isFixed = Boolean(lackingAt(system, [id], 'operator'));
      nodes.push(keep(id, [component, box, isSelected, ports, label, isFixed], () => ({ ...componentNode(component, box, isSelected, ports, label), ...(isFixed && { connectable: false }) })));
    } else {
      const frame = frameOf(id, box, system);
      if (frame) nodes.push(keep(id, [JSON.stringify(frame), box, isSelected, component], () => frameNode(id, frame, box, isSelected, component)));
    }
  }
  return nodes;
}

function connectedPorts(wires: Iterable<Connector>): Map<string, string[]> {
  const found = new Map<string, string[]>();
  for (const wire of wires) for (const end of [wire.source, wire.target]) grouped(found, end.component, end.port);
  return found;
}

function componentNode(component: Component, box: Box, isSelected: boolean, connected: string, label: Label): ComponentNodeType {
  return {
    ...placedNode(component.id, box, isSelected),
    type: 'component', data: { component, box, connected }, handles: portHandles(component, box), zIndex: 10,
    ariaLabel: label(component.name, component.type, component.word, component.ports.length),
  };
}

function frameNode(id: string, frame: Frame, box: Box, isSelected: boolean, composite: Component | undefined): FrameNodeType {
  const ports = composite ? portHandles(composite, box) : [];
  return {
    ...placedNode(id, box, isSelected),
    type: 'frame', data: { frame, box, composite: composite ?? null }, zIndex: frame.isFolded ? 10 : 0, draggable: frame.isFolded, focusable: false,
    handles: [...ports, handle('target', 'target', 'left', sideHeight(box, 'left'), box), handle('source', 'source', 'right', sideHeight(box, 'right'), box)],
  };
}

function placedNode(id: string, { x, y, width, height }: Box, selected: boolean) {
  // Sizes and handles are given, so that wires to boxes outside of the window can be drawn without measuring them.
  return { id, position: { x, y }, width, height, measured: { width, height }, selected };
}

function portHandles(component: Component, box: Box): NodeHandle[] {
  return placedPorts(component, box).map(({ port, side, y, x }) => handle(port.name, endKind(port), side, y, box, x));
}

/** Which end of a wire React Flow finds at a port; with `ConnectionMode.Loose` a wire may end at a "source", too. */
export const endKind = (port: Port): 'source' | 'target' => (port.direction === 'in' ? 'target' : 'source');

/** Where a folded frame takes the wires of one side. */
export const sideHeight = (box: Box, side: 'left' | 'right'): number => box.ports[side]?.y ?? HEADER;

function handle(id: string, type: 'source' | 'target', side: Side, y: number, box: Box, along = 0): NodeHandle {
  if (side === 'top' || side === 'bottom')
    return { id, type, position: POSITIONS[side], x: along - HANDLE / 2, y: side === 'top' ? 0 : box.height - HANDLE, width: HANDLE, height: HANDLE };
  // A wire begins at the outer edge of its handle: that edge stands on the border of the box.
  const [position, x] = side === 'right' ? [Position.Right, box.width - HANDLE] as const : [Position.Left, 0] as const;
  return { id, type, position, x, y: y - HANDLE / 2, width: HANDLE, height: HANDLE };
}

function frameOf(id: string, box: Box, system: System): Frame | null {
  const kind = box.kind as Frame['kind'];
  const inside = [...system.components.values()].filter((one) =>
    kind === 'composite' ? one.composite === id : kind === 'process' ? one.process === id : one.manager === id);
  const shared = { kind, isFolded: box.is_folded, counts: countsIn(inside) };
  const record: Manager | Process | Component | undefined =
    kind === 'composite' ? system.components.get(id) : kind === 'process' ? system.processes.get(id) : system.managers.get(id);
  if (!record) return null;
  if ('look' in record) return { ...shared, name: record.name, state: record.word, isTroubled: record.look === 'error', why: record.remark };
  return { ...shared, name: record.name, state: record.state, isTroubled: record.state !== 'up' && record.state !== 'starting', why: record.why };
}

export function buildEdges(
  { system, boxes, selection }: Scene, layout: Layout, placed: Places,
  label: (source: string, target: string) => string, keep: ReturnType<typeof keeper<WireEdgeType>>,
): WireEdgeType[] {
  const edges: WireEdgeType[] = [];
  const lanes = lanesOf(system.connectors.values());
  for (const wire of system.connectors.values()) {
    const source = shownAs(wire.source.component, system, boxes);
    const target = shownAs(wire.target.component, system, boxes);
    if (!source || !target || (source === target && wire.source.component !== wire.target.component)) continue;
    // The path of the layout holds while both ends stand where the layout has put them.
    const path = placed.has(source) || placed.has(target) ? null : (layout.paths[wire.id] ?? null);
    const bends = layout.bends?.[wire.id] ?? null;
    const isSelected = selection.has(wire.id);
    const isNear = selection.has(source) || selection.has(target);
    const ends = [handleOf(wire.source, source, 'source', system), handleOf(wire.target, target, 'target', system)] as const;
    const lane = lanes.get(wire.id) ?? { between: 0, atPort: 0 };
    const make = (): WireEdgeType => ({
      id: wire.id, type: 'wire', source, target, sourceHandle: ends[0], targetHandle: ends[1],
      data: { wire, path, bends, lane, isNear }, selected: isSelected, zIndex: isSelected ? 20 : 5,
      ariaLabel: label(endText(wire.source), endText(wire.target)),
    });
    edges.push(keep(wire.id, [wire, source, target, ends[0], ends[1], path, JSON.stringify(bends), lane.between, lane.atPort, isSelected, isNear, label], make));
  }
  return edges;
}

const BETWEEN = 10;
/** As the server draws them: see `rtkit/drawing/parallel.py`. */
const [AT_PORT, PORT] = [4, 8];

function lanesOf(wires: Iterable<Connector>): Map<string, Lane> {
  const [boxes, ports] = [new Map<string, string[]>(), new Map<string, string[]>()];
  for (const { id, source, target } of wires) {
    grouped(boxes, `${source.component}\n${target.component}`, id);
    grouped(ports, `${portPath(source)}\n${portPath(target)}`, id);
  }
  const lanes = new Map<string, Lane>();
  for (const ids of boxes.values()) ids.forEach((id, place) => lanes.set(id, { between: (place - (ids.length - 1) / 2) * BETWEEN, atPort: 0 }));
  for (const ids of ports.values())
    ids.forEach((id, place) => lanes.set(id, { between: 0, ...lanes.get(id), atPort: Math.round((place - (ids.length - 1) / 2) * Math.min(AT_PORT, PORT / Math.max(1, ids.length - 1))) }));
  return lanes;
}

function grouped(groups: Map<string, string[]>, key: string, id: string): void {
  const group = groups.get(key);
  if (group) group.push(id);
  else groups.set(key, [id]);
}

/** A folded box takes the wires of all that it holds at one place on each side. */
function handleOf(end: PortEnd, shown: string, side: 'source' | 'target', system: System): string {
  const isOwn = shown === end.component && system.components.get(shown)?.ports.some((port) => port.name === end.port);
  return isOwn ? end.port : side;
}
