/** What the room shows, as the address tells it: `do:FILE`, `job:ID`, `compare:FILE|FILE`, `order:FILE`. */
export interface Place { tab: 'do' | 'job' | 'compare' | 'order'; of: string; other: string }

const TABS = ['do', 'job', 'compare', 'order'] as const;

export function placeOf(text: string): Place {
  const at = text.indexOf(':');
  const tab = TABS.find((one) => one === text.slice(0, at)) ?? 'do';
  const [of = '', other = ''] = at < 0 ? [''] : text.slice(at + 1).split('|');
  return { tab, of, other };
}

export const textOf = ({ tab, of, other }: Place): string => `${tab}:${of}${other ? `|${other}` : ''}`;
