import { readGui, writeGui, type Gui } from './widgets';

/** The kinds of widgets that one may choose from; "" is the usual one for the type. */
export const KINDS = ['', 'label', 'text', 'number', 'slider', 'knob', 'toggle', 'choice', 'vector', 'joystick', 'plot', 'map', 'image', 'table', 'tree'] as const;

/** One property of a page that was put together, how it is drawn, and between which numbers. */
export interface Item { target: string; kind: string; min?: string; max?: string }

/** Kinds that need to know the least and the greatest number. */
export const hasBounds = (kind: string): boolean => kind === 'slider' || kind === 'knob';

/** A page that was put together: what it is called, and its properties in order. */
export interface PageLayout { title: string; items: readonly Item[] }

export const NO_LAYOUT: PageLayout = { title: '', items: [] };

const gui = (attributes: Record<string, string>, children: Gui[] = []): Gui => ({ name: 'gui', attributes, children, leaf: null });

/** A page as it is saved: a `<gui>` whose children name properties. */
export const textOf = ({ title, items }: PageLayout): string => writeGui(gui(
  { kind: 'group', label: title }, items.map(({ target, kind, min, max }) => gui({ name: target, ...(kind && { kind }), ...(hasBounds(kind) && { ...(min && { min }), ...(max && { max }) }) })),
));

/** Reads a page that was saved; throws where it is none. */
export function layoutOf(text: string): PageLayout {
  const { attributes, children } = readGui(text);
  const items = children.flatMap(({ attributes: { name, kind, min, max } }) => (name ? [{ target: name, kind: kind ?? '', ...(min && { min }), ...(max && { max }) }] : []));
  return { title: attributes['label'] ?? '', items };
}

/** The items with one moved by so many places. */
export function moved(items: readonly Item[], index: number, by: number): readonly Item[] {
  const to = index + by;
  const item = items[index];
  if (!item || to < 0 || to >= items.length) return items;
  const rest = items.filter((_, at) => at !== index);
  return [...rest.slice(0, to), item, ...rest.slice(to)];
}

/** A name that a file in a storage service may have. */
export const isFileName = (name: string): boolean => /^[\w+~-]+$/.test(name) && !/^(properties|parameters|gui|listen|meta|history)$/.test(name);
