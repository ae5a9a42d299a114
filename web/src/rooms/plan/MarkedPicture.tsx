import { useEffect, useRef } from 'react';

import type { ComparedBox, Comparison, Mark } from './types';
import type { PlanTexts } from './usePlanTexts';

const NAMES: Readonly<Record<Mark, string>> = { '': 'same', '+': 'added', '-': 'removed', '~': 'changed' };
const EDGE = 16;

interface Props { texts: PlanTexts; picture: Comparison['picture']; chosen: string; onChoose: (subject: string) => void }

/** Both systems in one picture: what was added, is missing or changed has its sign, its line and its colour. */
export function MarkedPicture({ texts, picture, chosen, onChoose }: Props) {
  const ref = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (chosen) ref.current?.querySelector('.is-chosen')?.scrollIntoView({ block: 'nearest', inline: 'nearest' });
  }, [chosen]);
  if (!picture.boxes.length) return null;
  const [width, height] = [picture.width + 2 * EDGE, picture.height + 2 * EDGE];
  return (
    // The list below tells the same by words: the picture is one image to those who do not see it.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- it scrolls, so that keys must reach it
    <div ref={ref} className="compared" role="group" aria-label={texts.picture} tabIndex={0}>
      <svg role="img" aria-label={texts.picture} viewBox={`${-EDGE} ${-EDGE} ${width} ${height}`} width={width} height={height}>
        {picture.wires.map((wire, index) => (
          <g key={index} className={`wire-${NAMES[wire.mark]} ${wire.id === chosen ? 'is-chosen' : ''}`} onClick={() => onChoose(wire.id)}>
            <polyline points={wire.path.map((point) => point.join()).join(' ')} />
            {wire.mark && <Sign mark={wire.mark} at={middle(wire.path)} />}
          </g>
        ))}
        {picture.boxes.map((box) => (
          <g key={box.id} className={`box-${NAMES[box.mark]} ${box.id === chosen ? 'is-chosen' : ''}`} transform={`translate(${box.x} ${box.y})`} onClick={() => onChoose(box.id)}>
            <Box box={box} />
          </g>
        ))}
      </svg>
    </div>
  );
}

function Box({ box }: { box: ComparedBox }) {
  return (
    <>
      <rect width={box.width} height={box.height} rx="6" />
      <text x={box.width / 2} y={18} className="title">{box.id}</text>
      <text x={box.width / 2} y={33} className="kind">{box.type}</text>
      {box.ports.map((port) => {
        const isLeft = port.side === 'left';
        return (
          <g key={`${port.side} ${port.name}`}>
            <circle cx={isLeft ? 0 : box.width} cy={port.y} r="3.5" />
            <text x={isLeft ? 8 : box.width - 8} y={port.y + 4} className={isLeft ? 'pin' : 'pin is-right'}>{port.name}</text>
          </g>
        );
      })}
      {box.mark && <Sign mark={box.mark} at={[box.width, 0]} />}
    </>
  );
}

function Sign({ mark, at: [x, y] }: { mark: Mark; at: readonly [number, number] }) {
  return <g className="sign" transform={`translate(${x} ${y})`}><circle r="9" /><text y="4.5">{mark === '-' ? '−' : mark}</text></g>;
}

/** The middle of the longest part of a wire. */
function middle(path: readonly [number, number][]): [number, number] {
  let best: [number, number] = path[0] ?? [0, 0];
  let longest = -1;
  path.slice(1).forEach(([x, y], index) => {
    const [fromX, fromY] = path[index] ?? [x, y];
    const length = Math.abs(x - fromX) + Math.abs(y - fromY);
    if (length > longest) [longest, best] = [length, [(x + fromX) / 2, (y + fromY) / 2]];
  });
  return best;
}
