import { BaseEdge, type EdgeProps } from '@xyflow/react';
import { memo } from 'react';

import { roundedPath } from '../../canvas/path';
import type { WayEdgeType } from './chart';

/** A transition along the path of the layout; its head points at the state that it leads to. */
export const WayEdge = memo(function WayEdge({ id, data, selected }: EdgeProps<WayEdgeType>) {
  const end = data?.path.at(-1);
  if (!data || !end) return null;
  const [x, y] = end;
  return (
    <g className={['way', data.isLast && 'is-last', selected && 'is-selected'].filter(Boolean).join(' ')}>
      <BaseEdge id={id} path={roundedPath(data.path)} interactionWidth={24} />
      <path className="head" d={`M${x - 9},${y - 4.5}L${x},${y}L${x - 9},${y + 4.5}z`} />
    </g>
  );
});
