import '../../../../rtkit/wires/http/static/frames.js';
import { mapWords } from '../../../../rtkit/wires/http/static/map.js';
import { itemTexts, read, write } from '../../../../rtkit/wires/http/static/values.js';
import '../../../../rtkit/wires/http/static/widgets.css';
import { words } from '../../../../rtkit/wires/http/static/widgets.js';

import type { Held } from './source';

export { itemTexts };

/** An element of a value: of a `<gui>` a widget, with those of what lies below. */
export interface Gui { name: string; attributes: Record<string, string>; children: Gui[]; leaf: unknown }

/** What widgets ask: the values of properties, a SET of one, and where a component of a service is. */
export interface Source {
  isReadOnly: boolean;
  get: (target: string, isRaw?: boolean) => Promise<string | ArrayBuffer>;
  /** The value of a property that is a text. */
  text: (target: string) => Promise<string>;
  set: (target: string, text: string, held?: Held) => Promise<void>;
  component: (gui: Gui) => (() => Promise<string>) | undefined;
}

/** What came with a value. */
export interface Told { quality: string; code: string; isRaw: boolean; why?: string }

/** The element `rt-panel`: all widgets of a page. */
export interface PanelElement extends HTMLElement {
  redraw: (gui: Gui, source: Source) => void;
  show: (name: string, text: string, told: Told) => void;
  lock: (isLocked: boolean) => void;
}

export const createPanel = (): PanelElement => document.createElement('rt-panel') as PanelElement;

/** Has widgets speak another language; those drawn from then on do. */
export function speak(texts: { widgets: object; map: object }): void {
  Object.assign(words, texts.widgets);
  Object.assign(mapWords, texts.map);
}

/** Reads the text of an element; throws where it is none. */
export function readGui(text: string): Gui {
  const value = read(text);
  if (typeof value === 'object' && value !== null && 'name' in value && value.name === 'gui') return value as Gui;
  throw new Error('This is no <gui>.');
}

export const writeGui = (gui: Gui): string => write(gui);
