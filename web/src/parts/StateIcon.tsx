import type { Look } from '../model/types';

/** A shape for each look, so that state is told without colour. The word stands beside it, so readers skip the shape. */
export function StateIcon({ look }: { look: Look }) {
  return (
    <svg className={`state-icon look-${look}`} viewBox="0 0 16 16" aria-hidden="true" focusable="false">
      {SHAPES[look]}
    </svg>
  );
}

const SHAPES: Record<Look, React.ReactNode> = {
  active: <><circle className="solid" cx="8" cy="8" r="7" /><path className="mark-solid" d="M6.4 4.8v6.4L11.4 8z" /></>,
  inactive: <><circle className="ring" cx="8" cy="8" r="6" /><path className="mark" d="M6.4 5.8v4.4M9.6 5.8v4.4" /></>,
  error: <><path className="solid" d="M8 .8 15.2 8 8 15.2.8 8z" /><path className="on-solid" d="M8 4.4v4.4M8 10.9v.4" /></>,
  created: <circle className="ring" cx="8" cy="8" r="6" strokeDasharray="2.2 1.6" />,
  unknown: <><circle className="ring" cx="8" cy="8" r="6.4" /><path className="mark" d="M6.2 6.4c0-2.6 3.7-2.4 3.7-.2 0 1.4-1.9 1.5-1.9 3M8 11.4v.3" /></>,
  zombie: <><rect className="solid" x="1" y="1" width="14" height="14" rx="3" /><path className="on-solid" d="m5 5 6 6M11 5l-6 6" /></>,
  stuck: <><path className="solid" d="M5.1 1h5.8L15 5.1v5.8L10.9 15H5.1L1 10.9V5.1z" /><path className="on-solid" d="M4.6 8h6.8" /></>,
  unreachable: <><path className="ring" d="M10.6 2.6A6 6 0 0 0 2.7 10.6M5.4 13.4a6 6 0 0 0 7.9-8" /><path className="mark" d="m2 14 12-12" /></>,
  restarting: <><path className="ring" d="M13.6 6A6 6 0 1 0 14 9" /><path className="mark" d="M14.4 2.4V6h-3.6" /></>,
};
