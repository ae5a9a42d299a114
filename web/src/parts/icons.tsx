/** Drawn signs of buttons. Each stands beside a word or in a button that has a label. */
const PATHS = {
  undo: 'M6.5 3 3 6.5 6.5 10M3 6.5h6.5a3.5 3.5 0 0 1 0 7H7',
  redo: 'M9.5 3 13 6.5 9.5 10M13 6.5H6.5a3.5 3.5 0 0 0 0 7H9',
  arrange: 'M2.5 3h4v4h-4zM9.5 3h4v4h-4zM9.5 9.5h4v4h-4zM6.5 5h3M4.5 7v4.5h5',
  fit: 'M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10',
  plus: 'M8 3v10M3 8h10', minus: 'M3 8h10', close: 'm4 4 8 8M12 4l-8 8',
  search: 'M7 2.5a4.5 4.5 0 1 1 0 9 4.5 4.5 0 0 1 0-9zM10.4 10.4l3.1 3.1',
  left: 'M2.5 3h11v10h-11zM6 3v10', right: 'M2.5 3h11v10h-11zM10 3v10', bottom: 'M2.5 3h11v10h-11zM2.5 9.5h11',
  open: 'm4 6 4 4 4-4', shut: 'm6 4 4 4-4 4', help: 'M5.8 6c0-3 4.6-2.8 4.6-.2 0 1.7-2.4 1.8-2.4 3.7M8 12.2v.3',
  up: 'm4 10 4-4 4 4', down: 'm4 6 4 4 4-4', copy: 'M5.5 5.5h8v8h-8zM3.5 10.5h-1v-8h8v1', pause: 'M5.5 3.5v9M10.5 3.5v9', play: 'M5 3.5v9l7.5-4.5z',
  plot: 'M2.5 13.5v-11M2.5 13.5h11M4.5 10.5 7 6.5l2.5 2.5 3.5-5',
  sun: 'M8 5.2a2.8 2.8 0 1 1 0 5.6 2.8 2.8 0 0 1 0-5.6zM8 1.5v1.4M8 13.1v1.4M1.5 8h1.4M13.1 8h1.4M3.4 3.4l1 1M11.6 11.6l1 1M3.4 12.6l1-1M11.6 4.4l1-1',
} as const;

export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg className="icon" viewBox="0 0 16 16" aria-hidden="true" focusable="false">
      <path d={PATHS[name]} />
    </svg>
  );
}
