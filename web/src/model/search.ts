/** How well words match a text: 0 not at all; more is better. Every word must be somewhere in the text. */
export function score(text: string, query: string): number {
  const hay = text.toLowerCase();
  let total = 1;
  for (const word of query.toLowerCase().split(/\s+/).filter(Boolean)) {
    const at = hay.indexOf(word);
    if (at < 0) return 0;
    if (at === 0) total += 3;
    else if (/[^a-z0-9]/.test(hay[at - 1] ?? '')) total += 2;
    else total += 1;
  }
  return total;
}

export const matches = (text: string, query: string): boolean => score(text, query) > 0;
