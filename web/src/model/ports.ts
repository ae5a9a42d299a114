import type { Box, Component, Connector, Interface, Port, PortPlace } from './types';

/** A port at its box: the layout decides its side and its height [px below the top of the box]. */
export interface PlacedPort extends PortPlace { port: Port }

/** The ports that the layout has placed; one that it does not know yet waits for the next layout. */
export function placedPorts(component: Component, box: Box): PlacedPort[] {
  return component.ports.flatMap((port) => {
    const place = box.ports[port.name];
    return place ? [{ port, ...place }] : [];
  });
}

/** Where along its side a port stands, as the style of an element inside the box. */
export const alongSide = ({ side, x, y }: PortPlace) => (side === 'top' || side === 'bottom' ? { left: x ?? 0 } : { top: y });

/** Wires at a port. */
export function wiresAt(connectors: Iterable<Connector>, component: string, port?: string): Connector[] {
  const found: Connector[] = [];
  for (const wire of connectors)
    if ([wire.source, wire.target].some((end) => end.component === component && (port === undefined || end.port === port)))
      found.push(wire);
  return found;
}

/** What travels through a port: its data type, or the interfaces of a service port. */
export function portType(port: Port): string {
  if (port.direction !== 'service') return port.type;
  return port.interfaces.map((one) => `${signed(one)}: ${one.type}`).join(', ');
}

/** An interface with the sign of its side: a ball that is provided, a socket that is required. */
export const signed = ({ polarity, instance }: Interface): string => `${polarity === 'Provided' ? '○' : '◠'} ${instance}`;

/** Interfaces of two service ports that belong together: of one type, provided by one and required by the other. */
export function pairsOf(own: Port, far: Port | undefined): [Interface, Interface][] {
  return own.interfaces.flatMap((mine) => (far?.interfaces ?? [])
    .filter((its) => its.type === mine.type && its.polarity !== mine.polarity).map((its): [Interface, Interface] => [mine, its]));
}

/** The last part of a path, as the tree shows it: `Motor0` of `/localhost/Motor0.rtc`. */
export function shortName(path: string): string {
  const last = path.slice(path.lastIndexOf('/') + 1);
  return last.replace(/\.(rtc|mgr)$/, '');
}
