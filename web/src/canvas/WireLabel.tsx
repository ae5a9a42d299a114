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
  const since = isStale(hz, sample, now) && sample?.at ? age(sample.at, now) : '';
  // Signs tell what is amiss also where there is no room for numbers: those are in the inspector.
  const amiss = pressure?.dropped ? { sign: '▼', text: `▼ ${pressure.dropped}` } : pressure?.isTight ? { sign: '▤', text: `▤ ${pressure.waiting}/${pressure.length}` } : null;
  const flow = [wire.trouble && '⚠', since ? `◷ ${since}` : hz !== null && rateText(hz)].filter(Boolean).join(' ');
  const long = [flow, amiss?.text].filter(Boolean).join(' ');
  const told = long.length <= most ? long : [flow, amiss?.sign].filter(Boolean).join(' ');
  return (
    <>
      {told && <text x={x} y={y - 5} className={`${since && 'is-stale'} ${amiss ? 'is-tight' : ''}`}>{told}</text>}
      {value && <text x={x} y={y + 11} className="value">{value}</text>}
    </>
  );
});
