import { ReactFlowProvider, useStore, type EdgeProps, type NodeProps, type ReactFlowProps } from '@xyflow/react';
import { render } from '@testing-library/react';
import { beforeEach, describe, expect, it, vi } from 'vitest';

import { Canvas } from '../src/canvas/Canvas';
import { ComponentNode } from '../src/canvas/ComponentNode';
import type { ComponentNodeType, GraphNode, WireEdgeType } from '../src/canvas/graph';
import { Wire } from '../src/canvas/Wire';
import { EMPTY_SYSTEM, reduceSystem } from '../src/model/system';
import type { Box, Layout } from '../src/model/types';
import { EditorContext } from '../src/shell/contexts';
import type { Editor } from '../src/shell/editor';
import { FIRST_VIEW } from '../src/shell/view';
import { component, picture, port, wire } from './records';

type Given = ReactFlowProps<GraphNode, WireEdgeType>;
const { given } = vi.hoisted(() => ({ given: [] as unknown[] }));
vi.mock('@xyflow/react', async (original) => {
  const flow = await original<typeof import('@xyflow/react')>();
  const ReactFlow = (props: unknown) => {
    given.push(props);
    return null;
  };
  return { ...flow, ReactFlow, useStore: vi.fn(flow.useStore) };
});

const MANAGER = '/localhost/manager.mgr';
const sensor = component('Sensor0', { ports: [port('out', 'out')] });
const motor = component('Motor0', { ports: [port('speed', 'in')] });
const connector = wire('w', 'Sensor0.out', 'Motor0.speed');
const system = reduceSystem(EMPTY_SYSTEM, { kind: 'picture', picture: picture({ components: [sensor, motor, component('Camera0')], connectors: [connector] }) });
const box = (x: number, more: Partial<Box> = {}): Box => ({ x, y: 40, width: 100, height: 70, parent: MANAGER, kind: 'component', is_folded: false, ports: {}, ...more });
const layout: Layout = {
  revision: 1, width: 420, height: 160, paths: {},
  boxes: { [MANAGER]: box(0, { y: 0, width: 420, height: 160, parent: null, kind: 'manager' }), [sensor.id]: box(20), [motor.id]: box(160), '/localhost/Camera0.rtc': box(300) },
};
const editor = { select: vi.fn(), canChange: true } as unknown as Editor;

const shown = (more: Partial<Parameters<typeof Canvas>[0]> = {}) => (
  <EditorContext value={editor}>
    <Canvas system={system} shown={null} layout={layout} view={FIRST_VIEW} onOpen={() => undefined} onConnect={() => undefined} {...more} />
  </EditorContext>
);

/** What React Flow is given otherwise than the time before: it draws all boxes or wires anew for most of that. */
function changed(): string[] {
  const [before, after] = given.slice(-2) as [Given, Given];
  return Object.keys(after).filter((name) => name !== 'children' && after[name as keyof Given] !== before[name as keyof Given]);
}

beforeEach(() => void (given.length = 0));

describe('the diagram', () => {
  it('gives React Flow nothing new when rates have come', () => {
    const { rerender } = render(shown());
    rerender(shown({ system: reduceSystem(system, { kind: 'rates', rates: { connectors: {}, components: {} } }) }));
    expect(given).toHaveLength(2);
    expect(changed()).toEqual([]);
  });

  it('gives React Flow one new box when one is dragged', () => {
    const { rerender } = render(shown({ view: { ...FIRST_VIEW, placed: new Map([[motor.id, { x: 165, y: 42 }]]) } }));
    rerender(shown({ view: { ...FIRST_VIEW, placed: new Map([[motor.id, { x: 170, y: 44 }]]) } }));
    expect(changed()).toEqual(['nodes']);
    const [before, after] = given as [Given, Given];
    expect(after.nodes?.filter((node, index) => node !== before.nodes?.[index]).map((node) => node.id)).toEqual([motor.id]);
  });

  it('does what is asked for now, by functions that it gave before', () => {
    const [first, latest] = [vi.fn(), vi.fn()];
    const { rerender } = render(shown({ onOpen: first }));
    rerender(shown({ onOpen: latest }));
    const [{ nodes, onNodeDoubleClick }] = given as [Given];
    const node = nodes?.find((one) => one.id === motor.id);
    onNodeDoubleClick?.({} as never, node as GraphNode);
    expect([first.mock.calls.length, latest.mock.calls.length]).toEqual([0, 1]);
  });

  it('has no box and no wire ask React Flow, which would ask each again in every frame of a pan', () => {
    render(shown());
    const [{ nodes, edges }] = given as [Given];
    const node = nodes?.find((one) => one.id === motor.id) as ComponentNodeType;
    const [edge] = edges as [WireEdgeType];
    vi.mocked(useStore).mockClear();
    const page = render(
      <EditorContext value={{ ...editor, values: { subscribe: () => () => undefined, latest: () => undefined } as unknown as Editor['values'] }}>
        <ReactFlowProvider>
          <ComponentNode {...(node as unknown as NodeProps<ComponentNodeType>)} />
          <svg><Wire {...(edge as unknown as EdgeProps<WireEdgeType>)} sourceX={0} sourceY={0} targetX={90} targetY={0} /></svg>
        </ReactFlowProvider>
      </EditorContext>,
    );
    expect(page.container.querySelectorAll('.component, .wire')).toHaveLength(2);
    expect(useStore).not.toHaveBeenCalled();
  });
});
