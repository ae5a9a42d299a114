/** What becomes of a finger: React Flow ends a wire at a touch that ends, and knows nothing of one that the system takes away. */
const KINDS = { touchmove: 'touchmove', touchend: 'touchend', touchcancel: 'touchend' } as const;

/**
 * Has the document hear of a finger that began on an element as long as it is down. Touches go to where they began, and the box of a
 * port that was scrolled out of sight is in the page no more: nothing would end its wire. Returns what stops that.
 */
export function keptTouch(began: EventTarget | null): () => void {
  if (!(began instanceof Element)) return () => undefined;
  const { ownerDocument: page } = began;
  const pass = (event: Event) => {
    if (!(event instanceof TouchEvent) || (began.isConnected && event.type !== 'touchcancel')) return;
    const [touches, changedTouches] = [[...event.touches], [...event.changedTouches]];
    page.dispatchEvent(new TouchEvent(KINDS[event.type as keyof typeof KINDS], { touches, changedTouches, bubbles: true }));
  };
  const kinds = Object.keys(KINDS);
  kinds.forEach((kind) => began.addEventListener(kind, pass));
  return () => kinds.forEach((kind) => began.removeEventListener(kind, pass));
}
