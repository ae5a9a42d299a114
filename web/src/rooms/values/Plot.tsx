import 'uplot/dist/uPlot.min.css';

import { useEffect, useRef } from 'react';
import UPlot from 'uplot';

import { KEPT_S, type Sample } from '../../server/values';
import { curvesOf } from '../../model/flow';

const HEIGHT = 150;
/** Curves are told apart by colour and by dashes. */
const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3], [10, 4], [1, 3]];
const COLOURS = ['--accent', '--active', '--error', '--stuck', '--zombie', '--restarting'];
/** The screen shows no more steps than these. */
const STEP_MS = 100;

interface Props { label: string; samples: () => readonly Sample[]; isHeld: boolean }

/** Numbers of a port over the last minute. The table beside it tells readers the same. */
export function Plot({ label, samples, isHeld }: Props) {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const at = box.current;
    if (!at || isHeld) return undefined;
    let plot: UPlot | null = null;
    let known = '';
    const draw = () => {
      const { names, times, columns } = curvesOf(samples());
      // Other names, or light has turned to dark: a plot keeps the colours that it began with.
      const look = [getComputedStyle(at).color, ...names].join();
      if (look !== known) {
        plot?.destroy();
        plot = names.length ? new UPlot(optionsOf(names, at), undefined, at) : null;
        known = look;
      }
      const now = Date.now() / 1000;
      plot?.setSize({ width: at.clientWidth, height: HEIGHT });
      plot?.setData([times, ...columns] as UPlot.AlignedData, false);
      plot?.setScale('x', { min: now - KEPT_S, max: now });
    };
    at.replaceChildren();
    draw();
    const timer = setInterval(draw, STEP_MS);
    // What was drawn stays while the plot is held; the next one begins on an empty box.
    return () => clearInterval(timer);
  }, [samples, isHeld]);
  return <div className="plot" role="img" aria-label={label} ref={box} />;
}

function optionsOf(names: readonly string[], at: HTMLElement): UPlot.Options {
  const style = getComputedStyle(at);
  const ink = style.color;
  const axis = { stroke: ink, font: `10px ${style.fontFamily}`, grid: { stroke: style.borderColor, width: 1 }, ticks: { show: false }, size: 44, values: (_plot: UPlot, splits: number[]) => splits.map((each) => String(Number(each.toPrecision(4)))) };
  return {
    width: at.clientWidth, height: HEIGHT, pxAlign: false, legend: { show: names.length > 1, live: false },
    cursor: { drag: { x: false, y: false } },
    scales: { x: { time: true }, y: { range: (_plot, low, high) => widened(low, high) } },
    axes: [{ ...axis, size: 22, values: (_plot, splits) => splits.map((each) => new Date(each * 1000).toLocaleTimeString([], { minute: '2-digit', second: '2-digit' })) }, axis],
    series: [{}, ...names.map((label, index) => ({
      label, stroke: colourOf(COLOURS[index % COLOURS.length] ?? '', at), dash: DASHES[index % DASHES.length] ?? [], width: 1.5, points: { show: false }, spanGaps: false,
    }))],
  };
}

/** The colour that a property of the page stands for in this scheme: a canvas does not read `light-dark()`. */
function colourOf(name: string, at: HTMLElement): string {
  const probe = document.createElement('i');
  probe.style.color = `var(${name})`;
  at.append(probe);
  const { color } = getComputedStyle(probe);
  probe.remove();
  return color;
}

/** Room above and below the curves; also where there is one value only. */
function widened(low: number | null, high: number | null): [number, number] {
  if (low === null || high === null) return [0, 1];
  const room = (high - low) * 0.08 || Math.abs(low) * 0.1 || 1;
  return [low - room, high + room];
}
