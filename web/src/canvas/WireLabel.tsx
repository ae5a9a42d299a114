import { memo } from 'react';

import { isStale, pressureAt, shortValue } from '../model/flow';
import { portPath, type Connector } from '../model/types';
import { age, rateText } from '../parts/numbers';
import { useNow } from '../parts/useNow';
import { useSample } from '../parts/useSample';

/** About the width of a sign of a label [px]. */
const SIGN = 6.2;
const LEAST = 6;
const MOST = 28;

interface Props { wire: Connector; hz: number | null; x: number; y: number; room: number }

/** What flows on a wire: its rate and what is amiss above it, its last value below, as far as there is room. */
export const WireLabel = memo(function WireLabel({ wire, hz, x, y, room }: Props) {
  const sample = useSample(portPath(wire.source));
  const pressure = pressureAt(useSample(portPath(wire.target)), wire.id);
  const now = useNow();
  const most = Math.min(Math.max(Math.floor(room / SIGN), LEAST), MOST);
  const value = shortValue(sample, most);
  const since = isStale(hz, sample) && sample?.at ? age(sample.at, now) : '';
  // The worst comes first: where there is little room, the rest is left out.
  const told = fitting([
    wire.trouble && '⚠',
    pressure?.dropped && `▼ ${pressure.dropped}`,
    pressure?.isTight && `▤ ${pressure.waiting}/${pressure.length}`,
    since && `◷ ${since}`,
    hz !== null && rateText(hz),
  ], most);
  return (
    <>
      {told && <text x={x} y={y - 5} className={`${since && 'is-stale'} ${pressure?.dropped || pressure?.isTight ? 'is-tight' : ''}`}>{told}</text>}
      {value && <text x={x} y={y + 11} className="value">{value}</text>}
    </>
  );
});

/** Parts, one behind the other, as many as fit; the first one always. */
function fitting(parts: readonly (string | number | false | null | undefined)[], most: number): string {
  let told = '';
  for (const part of parts) {
    if (!part) continue;
    const longer = told ? `${told} · ${part}` : String(part);
    if (told && longer.length > most) continue;
    told = longer;
  }
  return told;
}
