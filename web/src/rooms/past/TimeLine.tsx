import { memo, useMemo, type KeyboardEvent } from 'react';

import { countUpTo, neighbour } from '../../model/past';
import type { TreeEvent } from '../../model/types';
import { clock } from '../../parts/numbers';
import { useNow } from '../../parts/useNow';
import { useTexts } from '../../texts';
import './past.css';
import type { Shown } from './usePast';

/** The kinds of marks, each in a row of its own, so that they are told apart without colour. */
const LANES = ['trouble', 'state', 'tree', 'wire', 'other'] as const;
type Lane = (typeof LANES)[number];
const COLUMNS = 240;
const LANE_HEIGHT = 5;
/** What is shown at least [s]: a line of a few seconds would run under the hand. */
const LEAST_S = 30;

const KINDS: Record<string, Lane> = { RTC_STATUS: 'state', TREE_EVENT: 'tree', PORT_EVENT: 'wire', SUPERVISION: 'trouble' };
const TROUBLES = new Set(['ERROR', 'ABORTING', 'ZOMBIE', 'STUCK', 'LOST']);
const laneOf = (event: TreeEvent): Lane => (TROUBLES.has(event.event) ? 'trouble' : (KINDS[event.kind] ?? 'other'));

interface Props { since: number; events: readonly TreeEvent[]; past: Shown }

/** The time since the server has begun, with a mark for what happened; dragged, or moved by keys, it leads to any moment. */
export const TimeLine = memo(function TimeLine({ since, events, past }: Props) {
  const texts = useTexts().past;
  const now = useNow();
  const end = Math.max(now, since + LEAST_S);
  const marks = useMemo(() => marksOf(events, since, end), [events, since, end]);
  const at = past.time ?? end;
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.key === 'Escape') past.go(null);
    if (!['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown', 'PageUp', 'PageDown', 'Home', 'End'].includes(event.key)) return;
    event.preventDefault();
    const { key } = event;
    void past.load().then((loaded) => loaded && past.go(neighbour(loaded.times, loaded.since, past.time, key)));
  };
  return (
    <div className="time-line">
      <span className="time">{clock(since)}</span>
      <div className="track">
        <svg viewBox={`0 0 ${COLUMNS} ${LANES.length * LANE_HEIGHT}`} preserveAspectRatio="none" aria-hidden="true">
          {marks.map(({ lane, column }) => <rect key={`${lane} ${column}`} className={`mark-${lane}`} x={column} y={LANES.indexOf(lane) * LANE_HEIGHT} width="1" height={LANE_HEIGHT - 1} />)}
        </svg>
        <input type="range" aria-label={texts.line} aria-valuetext={past.time === null ? texts.now : texts.at(clock(past.time, true), countUpTo(past.times, past.time))}
          min={since} max={end} step="any" value={at} onKeyDown={onKeyDown}
          onChange={(event) => past.go(Number(event.target.value) >= now ? null : Number(event.target.value))} />
      </div>
      <button type="button" disabled={past.time === null} onClick={() => past.go(null)}>{texts.now}</button>
    </div>
  );
});

/** One mark for each column and row in which something happened. */
function marksOf(events: readonly TreeEvent[], since: number, end: number): { lane: Lane; column: number }[] {
  const found = new Map<string, { lane: Lane; column: number }>();
  for (const event of events) {
    const column = Math.min(Math.floor(((event.time - since) / (end - since)) * COLUMNS), COLUMNS - 1);
    const lane = laneOf(event);
    if (column >= 0) found.set(`${lane} ${column}`, { lane, column });
  }
  return [...found.values()];
}

/** Tells that what is shown was, and leads back. */
export function PastBanner({ past }: { past: Shown }) {
  const texts = useTexts().past;
  if (past.time === null) return null;
  const line = past.system ? texts.asItWas(clock(past.time)) : texts.loading;
  return <p className="banner banner-past" role="status">{line} <button type="button" onClick={() => past.go(null)}>{texts.now}</button></p>;
}
