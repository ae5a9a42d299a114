import { Handle, NodeResizeControl, type NodeProps } from '@xyflow/react';
import { memo, useContext } from 'react';

import { alongSide, placedPorts, portType, type PlacedPort } from '../model/ports';
import { portPath, type Component } from '../model/types';
import { StateIcon } from '../parts/StateIcon';
import { useEditor } from '../shell/contexts';
import { Anchors } from './Anchors';
import { ConnectingContext } from './ConnectingContext';
import { BoxDetailContext } from './DetailContext';
import { POSITIONS, endKind, type ComponentNodeType } from './graph';

export const ComponentNode = memo(function ComponentNode({ data, selected, isConnectable }: NodeProps<ComponentNodeType>) {
  const { component, box } = data;
  const connecting = useContext(ConnectingContext);
  const { resize, canChange } = useEditor();
  const detail = useContext(BoxDetailContext);
  const isDetailed = detail === 'all';
  if (detail === 'speck') return <div className={`speck look-${component.look} ${selected ? 'is-selected' : ''}`}><Anchors component={component} box={box} /></div>;
  const connected = new Set(data.connected.split('\n'));
  const isDim = connecting?.whys && !takesPart(component, connecting.from.component, connecting.whys);
  const classes = ['component', `look-${component.look}`, selected && 'is-selected', isDim && 'is-dim', !isDetailed && 'is-far'];
  return (
    <div className={classes.filter(Boolean).join(' ')}>
      <header>
        <StateIcon look={component.look} />
        <strong title={component.id}>{component.name}</strong>
        {isDetailed && <span className="type" title={component.type_id}>{component.type}</span>}
        {isDetailed && <span className="word">{component.word}</span>}
      </header>
      {!isDetailed && <Anchors component={component} box={box} />}
      {isDetailed && placedPorts(component, box).map((placed) => <PortRow key={placed.port.name} component={component} placed={placed} isConnected={connected.has(placed.port.name)} isConnectable={isConnectable} />)}
      {selected && resize && canChange && <NodeResizeControl position="bottom-right" className="sizer" minWidth={40} minHeight={28} />}
      {isDetailed && component.remark && <p className="remark" title={component.remark}>{component.remark}</p>}
    </div>
  );
});

function takesPart(component: Component, from: string, whys: ReadonlyMap<string, string>): boolean {
  return component.id === from || component.ports.some((port) => whys.get(portPath({ component: component.id, port: port.name })) === '');
}

interface PortRowProps { component: Component; placed: PlacedPort; isConnected: boolean; isConnectable: boolean }

function PortRow({ component, placed: { port, ...place }, isConnected, isConnectable }: PortRowProps) {
  const connecting = useContext(ConnectingContext);
  const why = connecting?.whys?.get(portPath({ component: component.id, port: port.name }));
  const isFrom = connecting?.from.component === component.id && connecting.from.port === port.name;
  const fit = !connecting?.whys || isFrom ? '' : why === '' ? 'fits' : 'fits-not';
  return (
    <div className={`port port-${port.direction} at-${place.side} ${isConnected ? 'is-connected' : ''} ${fit}`} style={alongSide(place)} title={`${port.name}: ${portType(port)}`} data-why={why}>
      <Handle id={port.name} type={endKind(port)} position={POSITIONS[place.side]} isConnectable={isConnectable} />
      <span>{port.name}</span>
    </div>
  );
}
