import type { Component, Connector, Port } from './types';

/** The sides of a box: in ports left, out and service ports right, each in their order. */
export function sides(component: Component): { left: Port[]; right: Port[] } {
  return {
    left: component.ports.filter((port) => port.direction === 'in'),
    right: component.ports.filter((port) => port.direction !== 'in'),
  };
}

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
  return port.interfaces.map((one) => `${one.polarity === 'PROVIDED' ? '○' : '◠'} ${one.instance}: ${one.type}`).join(', ');
}

/** The last part of a path, as the tree shows it: `Motor0` of `/localhost/Motor0.rtc`. */
export function shortName(path: string): string {
  const last = path.slice(path.lastIndexOf('/') + 1);
  return last.replace(/\.(rtc|mgr)$/, '');
}
