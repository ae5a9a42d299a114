import { useReactFlow } from '@xyflow/react';
import { useState, type PointerEvent } from 'react';

import type { Point } from '../model/types';
import { useEditor } from '../shell/contexts';
import { between, withPoint } from './bends';

interface Props { id: string; bends: readonly Point[]; ends: readonly [Point, Point] }

/** The bend points of a wire, to be dragged; small ones between them become new points, a double click removes one. By keyboard the inspector does it. */
export function BendHandles({ id, bends, ends }: Props) {
  const { bend } = useEditor();
  const flow = useReactFlow();
  const [held, setHeld] = useState<{ index: number; isNew: boolean } | null>(null);
  const at = (event: PointerEvent): Point => {
    const { x, y } = flow.screenToFlowPosition({ x: event.clientX, y: event.clientY });
    return [Math.round(x), Math.round(y)];
  };
  const grip = (index: number, isNew: boolean, [x, y]: Point) => (
    <circle
      key={`${isNew} ${index}`} cx={x} cy={y} r={isNew ? 4 : 6} className={`bend nopan ${isNew ? 'is-new' : ''}`} data-index={index}
      onPointerDown={(event) => {
        event.stopPropagation();
        event.currentTarget.setPointerCapture(event.pointerId);
        setHeld({ index, isNew });
        if (isNew) bend?.(id, withPoint(bends, index, at(event), true), false);
      }}
      onPointerMove={(event) => held?.index === index && bend?.(id, withPoint(bends, index, at(event), false), false)}
      onPointerUp={(event) => {
        if (held?.index !== index) return;
        setHeld(null);
        bend?.(id, withPoint(bends, index, at(event), false), true);
      }}
      onDoubleClick={() => !isNew && bend?.(id, bends.filter((_, number) => number !== index), true)}
    />
  );
  // While a new point is dragged it keeps the element that the pointer has captured: the same key in a list.
  const middles = between([ends[0], ...bends, ends[1]]);
  return (
    <>
      {bends.map((point, index) => (held?.isNew && held.index === index ? null : grip(index, false, point)))}
      {held?.isNew ? [grip(held.index, true, bends[held.index] ?? ends[0])] : middles.map((point, index) => grip(index, true, point))}
    </>
  );
}
