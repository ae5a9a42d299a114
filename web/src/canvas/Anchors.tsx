import { placedPorts } from '../model/ports';
import type { Box, Component } from '../model/types';
import { endKind } from './graph';

/** Where wires end at a box without its ports: React Flow measures every box that appears, and finds the ends by these marks. */
export function Anchors({ component, box }: { component: Component; box: Box }) {
  return placedPorts(component, box).map(({ port, side, y }) =>
    <i key={port.name} className={`${endKind(port)} at-${side}`} data-handleid={port.name} data-handlepos={side} style={{ top: y }} />);
}
