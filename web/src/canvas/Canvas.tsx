import '@xyflow/react/dist/base.css';

import {
  Background, BackgroundVariant, ConnectionLineType, ConnectionMode, MiniMap, ReactFlow, ReactFlowProvider, useReactFlow,
  type Connection, type NodeChange, type OnConnectStartParams,
} from '@xyflow/react';
import { useCallback, useEffect, useMemo, useRef, useState, type KeyboardEvent, type MouseEvent as ReactMouseEvent } from 'react';

import { isHeading, nearest, type Heading } from '../model/nearest';
import type { System } from '../model/system';
import { portPath, type Box, type Layout, type PortEnd } from '../model/types';
import { sentence } from '../server/api';
import { useStable } from '../parts/useStable';
import { useEditor } from '../shell/contexts';
import type { View } from '../shell/view';
import { useTexts } from '../texts';
import { wireAt } from './aim';
import { CanvasTools } from './CanvasTools';
import { ComponentNode } from './ComponentNode';
import { ConnectingContext, type Connecting } from './ConnectingContext';
import { DetailProvider } from './DetailProvider';
import { FrameNode } from './FrameNode';
import { FIT, buildEdges, buildNodes, keeper, listKeeper, placedBoxes, type GraphNode, type WireEdgeType } from './graph';
import { keptTouch } from './touch';
import { Wire } from './Wire';

const NODE_TYPES = { component: ComponentNode, frame: FrameNode };
const EDGE_TYPES = { wire: Wire };
const MINIMAP_SIZE = { width: 150, height: 100 };
const NO_ATTRIBUTION = { hideAttribution: true };
/** What the bar of the scope, the map and the buttons of the diagram take [px]. */
const [SIDE, TOP, BOTTOM] = [24, 64, 124];
const PAN_STEP = 80;
const MOVE_STEP = 20;
const SPEED_MS = matchMedia('(prefers-reduced-motion: reduce)').matches ? 0 : 250;

interface Props { system: System; shown: ReadonlySet<string> | null; layout: Layout; view: View; onOpen: () => void; onConnect: (from: PortEnd, to: PortEnd) => void }

export function Canvas(props: Props) {
  return <ReactFlowProvider><DetailProvider><Diagram {...props} /></DetailProvider></ReactFlowProvider>;
}

/** The diagram: boxes and wires of the layout, what the user has moved, and the keys and drags that work on them. */
function Diagram({ system, shown, layout, view, onOpen, onConnect }: Props) {
  const texts = useTexts();
  const editor = useEditor();
  const flow = useReactFlow<GraphNode, WireEdgeType>();
  const wrapper = useRef<HTMLDivElement>(null);
  const aimed = useRef<Element>(null);
  const { connecting, hint, begin, end } = useConnecting();

  const [keepNode] = useState(() => keeper<GraphNode>());
  const [keepEdge] = useState(() => keeper<WireEdgeType>());
  const [keepNodes] = useState(() => listKeeper<GraphNode>());
  const [keepEdges] = useState(() => listKeeper<WireEdgeType>());
  const boxes = useMemo(() => placedBoxes(layout, view.placed), [layout, view.placed]);
  const selection = useMemo(() => new Set(view.selection), [view.selection]);
  const scene = { system, boxes, selection };
  const nodes = keepNodes(buildNodes(scene, texts.canvas.component, keepNode));
  const edges = keepEdges(buildEdges(scene, layout, view.placed, texts.canvas.wire, keepEdge));

  useCentre(view.centre, boxes);
  useFit(shown, layout);

  const onNodesChange = useCallback((changes: NodeChange<GraphNode>[]) => {
    const places = new Map<string, { x: number; y: number }>();
    for (const change of changes) if (change.type === 'position' && change.position && change.dragging) places.set(change.id, change.position);
    if (places.size) editor.place(places);
    for (const change of changes) if (change.type === 'dimensions' && change.resizing && change.dimensions) editor.resize?.(change.id, change.dimensions);
  }, [editor]);

  const pick = (id: string, isAdded: boolean) => {
    if (!isAdded) editor.select([id]);
    else editor.select(selection.has(id) ? view.selection.filter((one) => one !== id) : [...view.selection, id]);
  };

  const nearestWire = (at: { clientX: number; clientY: number }) => wireAt(at, flow.screenToFlowPosition({ x: at.clientX, y: at.clientY }, { snapToGrid: false }));

  /** The areas of wires overlap: the nearest one is shown, and picked. */
  const aim = (wire: Element | null) => {
    if (wire !== aimed.current) aimed.current?.removeAttribute('data-aimed');
    wire?.setAttribute('data-aimed', '');
    aimed.current = wire;
  };

  const focusNode = (id: string) => {
    editor.reveal(id);
    wrapper.current?.querySelector<HTMLElement>(`.react-flow__node[data-id="${CSS.escape(id)}"]`)?.focus();
  };

  const go = (heading: Heading, isMoving: boolean, isAdding: boolean) => {
    const boxed = view.selection.filter((id) => boxes.get(id)?.kind === 'component' || boxes.get(id)?.is_folded);
    const current = isAdding ? boxed.at(-1) : boxed[0];
    if (current && isMoving) editor.place(new Map(boxed.map((id) => [id, shifted(boxes.get(id), heading)])));
    else if (current) {
      const reachable = new Map([...boxes].filter(([, box]) => box.kind === 'component' || box.is_folded));
      const next = nearest(reachable, current, heading);
      if (next && isAdding) editor.select([...view.selection.filter((id) => id !== next), next]);
      else if (next) focusNode(next);
    } else {
      const { x, y, zoom } = flow.getViewport();
      const [dx, dy] = ways(heading);
      void flow.setViewport({ x: x - dx * PAN_STEP, y: y - dy * PAN_STEP, zoom });
    }
  };

  const onKeyDown = (event: KeyboardEvent) => {
    const at = event.target instanceof Element ? event.target : null;
    if (at?.closest('button')) return;
    const focused = at?.closest<HTMLElement>('.react-flow__node, .react-flow__edge')?.dataset['id'];
    if (isHeading(event.key)) go(event.key, event.altKey, event.shiftKey);
    else if (event.key === 'Enter' || event.key === ' ') {
      if (focused) editor.select([focused]);
      if (event.key === 'Enter') onOpen();
    } else return;
    event.preventDefault();
  };

  /** Focus by keyboard selects, so that what the keys work on is what is shown. */
  const onFocus = ({ target }: { target: EventTarget }) => {
    const id = target instanceof HTMLElement && target.matches('.react-flow__node:focus-visible') ? target.dataset['id'] : undefined;
    if (id && !selection.has(id)) editor.reveal(id);
  };

  const connect = useStable(({ source, sourceHandle, target, targetHandle }: Connection) => {
    if (!sourceHandle || !targetHandle) return;
    const [from, to] = [{ component: source, port: sourceHandle }, { component: target, port: targetHandle }];
    const isTurned = system.components.get(from.component)?.ports.some((port) => port.name === from.port && port.direction === 'in');
    onConnect(isTurned ? to : from, isTurned ? from : to);
  });

  const allows = useStable(({ source, sourceHandle, target, targetHandle }: Connection | WireEdgeType): boolean => {
    const far = connecting && portPath(connecting.from) === `${source}:${sourceHandle}` ? `${target}:${targetHandle}` : `${source}:${sourceHandle}`;
    // Who is quicker than the server's answer is told by the dialog, or by the command.
    return !connecting?.whys || connecting.whys.get(far) === '';
  });

  // React Flow draws every box and wire anew when it is given another function.
  const onNodeClick = useStable((event: ReactMouseEvent, node: GraphNode) => {
    if (!(event.target instanceof Element && event.target.closest('button'))) pick(node.id, isAdding(event));
  });
  const onNodeDoubleClick = useStable((_: ReactMouseEvent, node: GraphNode) => (node.type === 'frame' ? editor.toggleFold(node.id) : onOpen()));
  const onEdgeClick = useStable((event: ReactMouseEvent, edge: WireEdgeType) => pick(nearestWire(event)?.getAttribute('data-id') ?? edge.id, isAdding(event)));
  const onEdgeMouseMove = useStable((event: ReactMouseEvent) => {
    if (!event.buttons) aim(nearestWire(event));
  });
  const onEdgeMouseLeave = useStable(() => aim(null));
  const onPaneClick = useStable(() => editor.select([]));

  return (
    <div className="canvas" ref={wrapper} onKeyDown={onKeyDown} onFocus={onFocus} role="presentation">
      <ConnectingContext value={connecting}>
        <ReactFlow<GraphNode, WireEdgeType>
          aria-label={texts.canvas.label}
          nodes={nodes} edges={edges} nodeTypes={NODE_TYPES} edgeTypes={EDGE_TYPES}
          onNodesChange={onNodesChange} onNodeClick={onNodeClick} onNodeDoubleClick={onNodeDoubleClick}
          onEdgeClick={onEdgeClick} onEdgeMouseMove={onEdgeMouseMove} onEdgeMouseLeave={onEdgeMouseLeave} onPaneClick={onPaneClick}
          onConnectStart={begin} onConnectEnd={end} onConnect={connect} isValidConnection={allows}
          nodesConnectable={editor.canChange} connectionMode={ConnectionMode.Loose} connectionLineType={ConnectionLineType.SmoothStep}
          connectionRadius={18} disableKeyboardA11y elementsSelectable={false} edgesFocusable onlyRenderVisibleElements
          fitView fitViewOptions={FIT} minZoom={0.05} maxZoom={2} deleteKeyCode={null} selectionKeyCode={null}
          multiSelectionKeyCode={null} zoomOnDoubleClick={false} elevateNodesOnSelect={false} nodeDragThreshold={3}
          proOptions={NO_ATTRIBUTION}
        >
          <Background variant={BackgroundVariant.Dots} gap={20} size={1} />
          <MiniMap<GraphNode> pannable zoomable ariaLabel={texts.canvas.minimap} nodeClassName={miniClass} nodeBorderRadius={6} style={MINIMAP_SIZE} />
          <CanvasTools />
        </ReactFlow>
      </ConnectingContext>
      {connecting && <p className="hint" role="status">{hint}</p>}
    </div>
  );
}

const isAdding = ({ shiftKey, ctrlKey, metaKey }: ReactMouseEvent): boolean => shiftKey || ctrlKey || metaKey;

const miniClass = (node: GraphNode): string => (node.type === 'component' ? `look-${node.data.component.look}` : `mini-${node.data.frame.kind}`);

const ways = (heading: Heading): [number, number] =>
  ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] } as const)[heading] as [number, number];

function shifted(box: Box | undefined, heading: Heading): { x: number; y: number } {
  const [dx, dy] = ways(heading);
  return { x: (box?.x ?? 0) + dx * MOVE_STEP, y: (box?.y ?? 0) + dy * MOVE_STEP };
}

/** Brings what was asked for to the middle, as soon as the layout shows it. */
function useCentre(centre: View['centre'], boxes: ReadonlyMap<string, Box>) {
  const flow = useReactFlow();
  const done = useRef(0);
  useEffect(() => {
    const box = centre && boxes.get(centre.id);
    if (!box || centre.count === done.current) return;
    done.current = centre.count;
    const { x, y, zoom } = flow.getViewport();
    const pane = document.querySelector('.react-flow')?.getBoundingClientRect();
    const [left, top] = [box.x * zoom + x, box.y * zoom + y];
    const isSeen = pane && zoom >= 0.5 && left >= 0 && top >= 0 && left + box.width * zoom <= pane.width && top + box.height * zoom <= pane.height;
    if (!isSeen) void flow.setCenter(box.x + box.width / 2, box.y + box.height / 2, { zoom: Math.max(zoom, 0.8), duration: SPEED_MS });
  }, [centre, boxes, flow]);
}

/** Shows all again when another part of the system is laid out. */
function useFit(shown: ReadonlySet<string> | null, layout: Layout) {
  const flow = useReactFlow();
  const latest = useRef(shown);
  useEffect(() => {
    latest.current = shown;
  }, [shown]);
  const fitted = useRef(shown);
  useEffect(() => {
    if (latest.current === fitted.current) return;
    fitted.current = latest.current;
    // React Flow may still have the boxes of before: what is to be seen is known from the layout.
    const pane = document.querySelector('.react-flow')?.getBoundingClientRect();
    if (!pane) return;
    const [width, height] = [pane.width - 2 * SIDE, pane.height - TOP - BOTTOM];
    const zoom = Math.min(1, width / layout.width, height / layout.height);
    const at = { x: SIDE + (width - layout.width * zoom) / 2, y: TOP + (height - layout.height * zoom) / 2, zoom };
    void flow.setViewport(at, { duration: SPEED_MS });
  }, [layout, flow]);
}

/** Asks the server which ports fit as soon as a wire is begun, and tells why the port under the pointer does not. */
function useConnecting() {
  const { api } = useEditor();
  const texts = useTexts();
  const [connecting, setConnecting] = useState<Connecting | null>(null);
  const [why, setWhy] = useState('');
  const release = useRef<() => void>(() => undefined);
  const begin = useCallback((event: MouseEvent | TouchEvent, { nodeId, handleId }: OnConnectStartParams) => {
    if (!nodeId || !handleId) return;
    release.current();
    release.current = keptTouch(event.target);
    const from = { component: nodeId, port: handleId };
    setConnecting({ from, whys: null });
    api.connectable(portPath(from)).then(
      (ports) => setConnecting((now) => now && { from, whys: new Map(ports.map((port) => [port.path, port.why])) }),
      (error: unknown) => setWhy(sentence(error)),
    );
  }, [api]);
  const end = useCallback(() => {
    release.current();
    setConnecting(null);
    setWhy('');
  }, []);
  useEffect(() => {
    if (!connecting?.whys) return undefined;
    const look = (event: MouseEvent) => {
      const at = event.target instanceof Element ? event.target.closest<HTMLElement>('[data-why]') : null;
      setWhy(at?.dataset['why'] ?? '');
    };
    document.addEventListener('mousemove', look);
    return () => document.removeEventListener('mousemove', look);
  }, [connecting?.whys]);
  const hasFit = connecting?.whys ? [...connecting.whys.values()].includes('') : true;
  const standing = !connecting?.whys ? texts.canvas.asking : hasFit ? texts.canvas.release : texts.canvas.noneFits;
  return { connecting, hint: why || standing, begin, end };
}

