import { useState } from 'react';

import { farEnds, endText } from '../model/does';
import { portType } from '../model/ports';
import type { System } from '../model/system';
import type { Component, Port } from '../model/types';
import { Icon } from '../parts/icons';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { LazyValues } from './LazyValues';
import { Link } from './Link';
import { useVerbs } from './useVerbs';

/** Ports of a component with their connectors. */
export function PortList({ system, component }: { system: System; component: Component }) {
  const texts = useTexts();
  if (!component.ports.length) return <p className="empty">{texts.inspector.noPorts}</p>;
  return <ul className="ports">{component.ports.map((port) => <PortItem key={port.name} system={system} component={component} port={port} />)}</ul>;
}

function PortItem({ system, component, port }: { system: System; component: Component; port: Port }) {
  const texts = useTexts();
  const { canChange } = useEditor();
  const { disconnect } = useVerbs();
  const ends = farEnds(system, component.id, port.name);
  const [isOpen, setOpen] = useState(false);
  return (
    <li>
      <p><span className={`direction direction-${port.direction}`}>{texts.directions[port.direction]}</span> <strong>{port.name}</strong> <span className="type">{portType(port)}</span>
        {port.direction !== 'service' && (
          <button type="button" className="quiet" aria-expanded={isOpen} aria-label={texts.inspector.valuesOf(port.name)} title={texts.inspector.valuesOf(port.name)} onClick={() => setOpen(!isOpen)}><Icon name="plot" /></button>
        )}
      </p>
      {isOpen && <LazyValues end={{ component: component.id, port: port.name }} direction={port.direction} />}
      {ends.length === 0 && <p className="empty">{texts.inspector.free}</p>}
      {ends.length > 1 && <button type="button" className="all" disabled={!canChange} onClick={() => disconnect(ends.map(({ wire }) => wire))}>{texts.manage.wires.all} ({ends.length})</button>}
      {ends.map(({ wire, far }) => (
        <p key={wire.id} className={`far ${wire.trouble ? 'is-troubled' : ''}`} title={wire.trouble}>
          <span aria-hidden="true">{port.direction === 'in' ? '←' : '→'}</span> <Link id={wire.id} text={hasTwin(ends, far) ? `${endText(far)} (${wire.name})` : endText(far)} />
          {wire.trouble && <span className="warning">⚠ {wire.trouble}</span>}
          <button type="button" className="quiet" disabled={!canChange} aria-label={texts.label.disconnect(endText({ component: component.id, port: port.name }), endText(far))} title={texts.act.disconnect} onClick={() => disconnect([wire])}><Icon name="close" /></button>
        </p>
      ))}
    </li>
  );
}

/** Whether several connectors lead to the same port: then their names tell them apart. */
const hasTwin = (ends: ReturnType<typeof farEnds>, far: { component: string; port: string }): boolean =>
  ends.filter((one) => one.far.component === far.component && one.far.port === far.port).length > 1;
