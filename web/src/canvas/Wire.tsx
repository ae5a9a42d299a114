import { BaseEdge, getSmoothStepPath, type EdgeProps } from '@xyflow/react';
import { memo, useContext } from 'react';

import type { Point } from '../model/types';
import { RatesContext, useEditor } from '../shell/contexts';
import { BendHandles } from './BendHandles';
import { WireDetailContext } from './DetailContext';
import type { WireEdgeType } from './graph';
import { WireLabel } from './WireLabel';
import { labelPlace, roundedPath } from './path';

/** A connector: along the path of the layout, else right-angled between its ends; thicker the more values it carries. */
export const Wire = memo(function Wire(props: EdgeProps<WireEdgeType>) {
  const { id, data, selected } = props;
  const { bend, canChange } = useEditor();
  const hz = useContext(RatesContext).connectors[id]?.hz ?? null;
  const { hasLabel, area } = useContext(WireDetailContext);
  const [path, x, y, room] = course(props);
  const isTroubled = Boolean(data?.wire.trouble);
  const classes = ['wire', isTroubled && 'is-troubled', data?.isNear && 'is-near', selected && 'is-selected', hz === 0 && 'is-quiet'];
  return (
    <g className={classes.filter(Boolean).join(' ')} data-speed={speed(hz)}>
      <BaseEdge id={id} path={path} interactionWidth={area} />
      {hasLabel && data && <WireLabel wire={data.wire} hz={hz} x={x} y={y} room={room} />}
      {selected && bend && canChange && data && <BendHandles id={id} bends={data.bends ?? []} ends={[[props.sourceX, props.sourceY], [props.targetX, props.targetY]]} />}
    </g>
  );
});

function course({ data, sourceX, sourceY, targetX, targetY, sourcePosition, targetPosition }: EdgeProps<WireEdgeType>): [path: string, x: number, y: number, room: number] {
  if (data?.bends?.length) {
    const points: Point[] = [[sourceX, sourceY], ...data.bends, [targetX, targetY]];
    return [roundedPath(points), ...labelPlace(points)];
  }
  if (data?.path && data.path.length > 1) return [roundedPath(data.path), ...labelPlace(data.path)];
  const { between, atPort } = data?.lane ?? { between: 0, atPort: 0 };
  const [path, x, y] = getSmoothStepPath({
    sourceX, sourceY: sourceY + atPort, targetX, targetY: targetY + atPort, sourcePosition, targetPosition, borderRadius: 6, centerX: (sourceX + targetX) / 2 + between,
  });
  return [path, x, y, Math.abs(targetX - sourceX)];
}

/** Four steps of thickness: nothing, a few, tens, hundreds of values a second. */
function speed(hz: number | null): number {
  if (!hz) return 0;
  return hz < 10 ? 1 : hz < 200 ? 2 : 3;
}
