import { sides } from '../model/ports';
import type { Box, Component, Port } from '../model/types';
import { portHeight } from './graph';

/** Where wires end at a box without its ports: React Flow measures every box that appears, and finds the ends by these marks. */
export function Anchors({ component, box }: { component: Component; box: Box }) {
  const { left, right } = sides(component);
  const anchor = (side: 'source' | 'target') => (port: Port, row: number) =>
    <i key={port.name} className={side} data-handleid={port.name} data-handlepos={side === 'source' ? 'right' : 'left'} style={{ top: portHeight(box, port.name, row) }} />;
  return <>{left.map(anchor('target'))}{right.map(anchor('source'))}</>;
}
