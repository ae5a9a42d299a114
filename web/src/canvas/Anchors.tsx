import { alongSide, placedPorts } from '../model/ports';
import type { Box, Component } from '../model/types';
import { endKind } from './graph';

/** Where wires end at a box without its ports: React Flow measures every box that appears, and finds the ends by these marks. */
export function Anchors({ component, box }: { component: Component; box: Box }) {
  return placedPorts(component, box).map(({ port, ...place }) =>
    <i key={port.name} className={`${endKind(port)} at-${place.side}`} data-handleid={port.name} data-handlepos={place.side} style={alongSide(place)} />);
}
