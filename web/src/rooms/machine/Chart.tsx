import '@xyflow/react/dist/base.css';

import { Background, BackgroundVariant, ConnectionLineType, MiniMap, ReactFlow, ReactFlowProvider, getViewportForBounds, useReactFlow, useStore, type FinalConnectionState } from '@xyflow/react';
import { useEffect, useRef, useState, type KeyboardEvent } from 'react';

import { CanvasTools } from '../../canvas/CanvasTools';
import { isHeading, nearest, type Heading } from '../../model/nearest';
import { StateNode } from './StateNode';
import { WayEdge } from './WayEdge';
import { buildEdges, buildNodes, reachable, type ChartGiven, type StateNodeType, type WayEdgeType } from './chart';
import { useMachineTexts } from './useMachine';

const NODE_TYPES = { state: StateNode };
const EDGE_TYPES = { way: WayEdge };
const FIT = { padding: { top: '28px', left: '28px', right: '28px', bottom: '52px' }, maxZoom: 1.15 } as const;
/** Smaller machines are seen whole. */
const MAPPED = 14;
const MIN_ZOOM = 0.1;

interface Props extends ChartGiven { onSelect: (id: string) => void; onOpen: () => void; onWay: (from: string, to: string) => void }

export function Chart(props: Props) {
  return <ReactFlowProvider><Drawn {...props} /></ReactFlowProvider>;
}

/** The state chart, and the keys and drags that work on it. */
function Drawn({ onSelect, onOpen, onWay, ...given }: Props) {
  const texts = useMachineTexts();
  const flow = useReactFlow<StateNodeType, WayEdgeType>();
  const wrapper = useRef<HTMLDivElement>(null);
  const [isDrawing, setDrawing] = useState(false);
  const { layout, selected } = given;
  const nodes = buildNodes(given, (one) => texts.nodeLabel(one.path, [
    one.box.kind === 'composite' ? texts.composite : texts.plain, one.isInitial && texts.initial, one.isFinal && texts.final, one.isActive && texts.active, one.sign && texts.signs[one.sign], one.problem,
  ].filter(Boolean).join(', ')));
  const edges = buildEdges(given, texts.wayLabel);

  const paneWidth = useStore((state) => state.width);
  const shape = Object.keys(layout.boxes).join('\n');
  const size = useRef(layout);
  useEffect(() => {
    size.current = layout;
  });
  useEffect(() => {
    const { width, height } = size.current;
    const pane = wrapper.current?.getBoundingClientRect();
    // `fitView` would wait for the next change of a box; the layout knows where all of them are.
    if (pane?.width) void flow.setViewport(getViewportForBounds({ x: 0, y: 0, width, height }, pane.width, pane.height, MIN_ZOOM, FIT.maxZoom, FIT.padding));
  }, [flow, shape, paneWidth]);

  const go = (heading: Heading) => {
    const from = layout.boxes[selected] ? selected : Object.keys(layout.boxes)[0];
    if (from === undefined) return;
    const next = from === selected ? nearest(reachable(layout, from), from, heading) : from;
    if (next === null) return;
    onSelect(next);
    wrapper.current?.querySelector<HTMLElement>(`.react-flow__node[data-id="${CSS.escape(next)}"]`)?.focus();
  };

  const onKeyDown = (event: KeyboardEvent) => {
    const at = event.target instanceof Element ? event.target : null;
    if (at?.closest('button')) return;
    const focused = at?.closest<HTMLElement>('.react-flow__node, .react-flow__edge')?.dataset['id'];
    if (isHeading(event.key)) go(event.key);
    else if (event.key === 'Enter' || event.key === ' ') {
      if (focused) onSelect(focused);
      if (event.key === 'Enter') onOpen();
    } else return;
    event.preventDefault();
  };

  const onFocus = ({ target }: { target: EventTarget }) => {
    const id = target instanceof HTMLElement && target.matches('.react-flow__node:focus-visible') ? target.dataset['id'] : undefined;
    if (id && id !== selected) onSelect(id);
  };

  /** A transition may be let go anywhere on a state, its own one too. */
  const onConnectEnd = (event: MouseEvent | TouchEvent, { fromNode }: FinalConnectionState) => {
    setDrawing(false);
    const { clientX, clientY } = 'changedTouches' in event ? (event.changedTouches[0] ?? { clientX: -1, clientY: -1 }) : event;
    const to = document.elementsFromPoint(clientX, clientY).map((one) => one.closest<HTMLElement>('.react-flow__node')?.dataset['id']).find(Boolean);
    if (fromNode && to) onWay(fromNode.id, to);
  };

  return (
    <div className="chart" ref={wrapper} onKeyDown={onKeyDown} onFocus={onFocus} role="presentation">
      <ReactFlow<StateNodeType, WayEdgeType>
        aria-label={texts.chartLabel} nodes={nodes} edges={edges} nodeTypes={NODE_TYPES} edgeTypes={EDGE_TYPES}
        onNodeClick={(event, node) => onSelect(event.target instanceof Element ? (event.target.closest<HTMLElement>('[data-way]')?.dataset['way'] ?? node.id) : node.id)}
        onNodeDoubleClick={onOpen} onEdgeClick={(_, edge) => onSelect(edge.id)} onPaneClick={() => onSelect('')}
        onConnectStart={() => setDrawing(true)} onConnectEnd={onConnectEnd}
        nodesConnectable={given.canEdit} nodesDraggable={false} connectionLineType={ConnectionLineType.Straight}
        disableKeyboardA11y elementsSelectable={false} edgesFocusable minZoom={MIN_ZOOM} maxZoom={2} deleteKeyCode={null} selectionKeyCode={null}
        multiSelectionKeyCode={null} zoomOnDoubleClick={false} elevateNodesOnSelect={false} proOptions={{ hideAttribution: true }}
      >
        <Background variant={BackgroundVariant.Dots} gap={20} size={1} />
        {given.machine.states.length > MAPPED && (
          <MiniMap<StateNodeType> pannable zoomable ariaLabel={texts.minimap} nodeClassName={(node) => (node.data.isActive ? 'mini-active' : 'mini-state')} style={{ width: 150, height: 90 }} />
        )}
        <CanvasTools />
      </ReactFlow>
      {isDrawing && <p className="hint" role="status">{texts.release}</p>}
    </div>
  );
}
