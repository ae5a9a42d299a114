import { describe, expect, it } from 'vitest';

import { buildEdges, buildNodes, keeper, placedBoxes, type GraphNode, type WireEdgeType } from '../src/canvas/graph';
import { EMPTY_SYSTEM, reduceSystem } from '../src/model/system';
import type { Box, Layout } from '../src/model/types';
import { change, component, picture, port, wire } from './records';

const MANAGER = '/localhost/manager.mgr';
const sensor = component('Sensor0', { ports: [port('out', 'out')] });
const motor = component('Motor0', { ports: [port('speed', 'in')] });
const system = reduceSystem(EMPTY_SYSTEM, { kind: 'picture', picture: picture({ components: [sensor, motor], connectors: [wire('w', 'Sensor0.out', 'Motor0.speed')] }) });
const box = (x: number, kind: Box['kind'], more: Partial<Box> = {}): Box => ({ x, y: 40, width: 100, height: 70, parent: MANAGER, kind, is_folded: false, ports: {}, ...more });
const frame = box(0, 'manager', { y: 0, width: 300, height: 120, parent: null });
const layout: Layout = { revision: 1, width: 300, height: 120, boxes: { [MANAGER]: frame, [sensor.id]: box(20, 'component'), [motor.id]: box(160, 'component') }, paths: { w: [[120, 92], [160, 92]] } };
const label = () => '';

function graph(given = system, placed = new Map<string, { x: number; y: number }>(), of = layout, keep = { nodes: keeper<GraphNode>(), edges: keeper<WireEdgeType>() }) {
  const scene = { system: given, boxes: placedBoxes(of, placed), selection: new Set<string>() };
  return { nodes: buildNodes(scene, label, keep.nodes), edges: buildEdges(scene, of, placed, label, keep.edges), boxes: scene.boxes };
}

describe('the graph', () => {
  it('keeps the identity of boxes that did not change', () => {
    const keep = { nodes: keeper<GraphNode>(), edges: keeper<WireEdgeType>() };
    const before = graph(system, new Map(), layout, keep);
    const active = reduceSystem(system, { kind: 'change', change: change(2, { components: [{ ...motor, look: 'active' }] }) });
    const after = graph(active, new Map(), layout, keep);
    const same = (id: string) => after.nodes.find((node) => node.id === id) === before.nodes.find((node) => node.id === id);
    expect([same(sensor.id), same(motor.id), after.edges[0] === before.edges[0]]).toEqual([true, false, true]);
  });

  it('draws a wire along the path of the layout until one of its ends is moved by hand', () => {
    expect(graph().edges[0]?.data?.path).toEqual([[120, 92], [160, 92]]);
    expect(graph(system, new Map([[motor.id, { x: 400, y: 40 }]])).edges[0]?.data?.path).toBeNull();
  });

  it('leads wires between the same two boxes beside each other', () => {
    const wires = ['a', 'b', 'c'].map((id) => wire(id, 'Sensor0.out', 'Motor0.speed'));
    const given = reduceSystem(EMPTY_SYSTEM, { kind: 'picture', picture: picture({ components: [sensor, motor], connectors: wires }) });
    expect(graph(given).edges.map((edge) => edge.data?.lane)).toEqual([{ between: -10, atPort: -4 }, { between: 0, atPort: 0 }, { between: 10, atPort: 4 }]);
  });

  it('takes side and height of a port from the layout', () => {
    const service = component('Tts0', { ports: [port('say', 'service')] });
    const given = reduceSystem(system, { kind: 'change', change: change(2, { components: [service] }) });
    const placed: Layout = { ...layout, boxes: { [service.id]: box(20, 'component', { ports: { say: { side: 'left', y: 52 } } }) } };
    expect(graph(given, new Map(), placed).nodes[0]?.handles).toMatchObject([{ id: 'say', position: 'left', x: 0, y: 47 }]);
  });

  it('grows the frame round a box that was moved out of it', () => {
    const grown = graph(system, new Map([[motor.id, { x: 400, y: 40 }]])).boxes.get(MANAGER);
    expect(grown && grown.x + grown.width).toBeGreaterThan(500);
  });

  it('ends wires of what is folded at the folded box', () => {
    const folded: Layout = { ...layout, boxes: { [MANAGER]: { ...frame, is_folded: true } }, paths: {} };
    expect(graph(system, new Map(), folded).edges).toEqual([]);
    const half: Layout = { ...layout, boxes: { [motor.id]: box(160, 'component'), [MANAGER]: { ...frame, is_folded: true } } };
    expect(graph(system, new Map(), half).edges[0]).toMatchObject({ source: MANAGER, sourceHandle: 'source', target: motor.id, targetHandle: 'speed' });
  });
});
