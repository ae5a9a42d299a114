import { Position, type Edge, type Node, type NodeHandle } from '@xyflow/react';

import type { Point } from '../../model/types';
import type { Sign } from './diff';
import { ROW, inside, initialOf, isActive, isIn, nameOf, outerOf, wayId } from './draft';
import type { Passage } from './live';
import type { ChartBox, ChartLayout, MachineRecord, Problem, StateRecord } from './types';

export type ChartState = {
  path: string; name: string; box: ChartBox;
  isInitial: boolean; isFinal: boolean; isActive: boolean;
  sign: Sign | undefined;
  problem: string; isOdd: boolean;
  ways: { id: string; text: string; isSelected: boolean; isLast: boolean; problem: string; sign: Sign | undefined }[];
};
export type StateNodeType = Node<ChartState & { canEdit: boolean }, 'state'>;
export type WayEdgeType = Edge<{ path: Point[]; isLast: boolean }, 'way'>;

const HANDLE = 10;

export interface ChartGiven {
  machine: MachineRecord;
  layout: ChartLayout;
  selected: string;
  active: string;
  last: Passage | null;
  marks: ReadonlyMap<string, Sign>;
  problems: readonly Problem[];
  canEdit: boolean;
}

/** The transition that was taken last: its cause is the text that the service makes of it. */
export function isLastWay(state: StateRecord, index: number, last: Passage | null): boolean {
  const way = state.transitions[index];
  if (!last || !way || !isIn(last.from, state.path)) return false;
  const parts = [way.on && `on ${way.on}`, way.when && `when ${way.when}`, way.after && `after ${Number(way.after)}`];
  return (parts.filter(Boolean).join(' ') || 'at once') === last.cause && (way.to === last.to || (!way.to && last.to === last.from));
}

export function buildNodes(given: ChartGiven, label: (state: ChartState) => string): StateNodeType[] {
  return given.machine.states.flatMap((state) => {
    const box = given.layout.boxes[state.path];
    if (!box) return [];
    const shown = chartState(given, state, box);
    const isComposite = box.kind === 'composite';
    return [{
      id: state.path, type: 'state' as const, position: { x: box.x, y: box.y }, width: box.width, height: box.height,
      measured: { width: box.width, height: box.height }, selected: given.selected === state.path,
      data: { ...shown, canEdit: given.canEdit }, zIndex: isComposite ? state.path.split('.').length : 60, handles: handles(state, box), draggable: false,
      ariaLabel: label(shown),
    }];
  });
}

function chartState({ machine, selected, active, last, marks, problems }: ChartGiven, state: StateRecord, box: ChartBox): ChartState {
  const own = problems.filter((one) => one.state === state.path);
  const at = (part: string) => own.filter((one) => one.part === part).map((one) => one.text).join(' ');
  const rest = own.filter((one) => !one.part.startsWith('transitions.'));
  return {
    path: state.path, name: nameOf(state.path), box,
    isInitial: initialOf(machine, outerOf(state.path)) === state.path, isFinal: state.is_final, isActive: isActive(state.path, active),
    sign: marks.get(state.path), problem: rest.map((one) => one.text).join(' '), isOdd: rest.every((one) => one.is_odd),
    ways: state.transitions.map((_, index) => {
      const id = wayId(state.path, index);
      return { id, text: box.rows[index] ?? '', isSelected: selected === id, isLast: isLastWay(state, index, last), problem: at(`transitions.${index}`), sign: marks.get(id) };
    }),
  };
}

export const rowHeight = (box: ChartBox, row: number): number => box.head + row * ROW + ROW / 2;

function handles(state: StateRecord, box: ChartBox): NodeHandle[] {
  const at = (id: string, type: 'source' | 'target', position: Position, x: number, y: number): NodeHandle =>
    ({ id, type, position, x: x - HANDLE / 2, y: y - HANDLE / 2, width: HANDLE, height: HANDLE });
  return [
    at('in', 'target', Position.Left, 0, rowHeight(box, 0)),
    at('new', 'source', Position.Bottom, box.width / 2, box.height),
    ...state.transitions.map((_, index) => at(`row-${index}`, 'source', Position.Right, box.width, rowHeight(box, index))),
  ];
}

export function buildEdges({ machine, layout, selected, last }: ChartGiven, label: (from: string, to: string, text: string) => string): WayEdgeType[] {
  return machine.states.flatMap((state) => state.transitions.flatMap((way, index) => {
    const id = wayId(state.path, index);
    const path = layout.paths[id];
    if (!path || !layout.boxes[way.to]) return [];
    return [{
      id, type: 'way' as const, source: state.path, target: way.to, sourceHandle: `row-${index}`, targetHandle: 'in', selected: selected === id,
      data: { path, isLast: isLastWay(state, index, last) }, zIndex: selected === id ? 59 : 40,
      ariaLabel: label(state.path, way.to, layout.boxes[state.path]?.rows[index] ?? ''),
    }];
  }));
}

/** States that arrow keys go between: those that lie beside each other, not round each other. */
export function reachable(layout: ChartLayout, from: string): Map<string, ChartBox> {
  return new Map(Object.entries(layout.boxes).filter(([path]) => path === from || !(isIn(path, from) || isIn(from, path))));
}

export const hasInside = (machine: MachineRecord, path: string): boolean => inside(machine, path).length > 0;
