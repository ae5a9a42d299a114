/* The custom elements of the panels of services: one source, in rtkit/wires/http/static. */

declare module '*/wires/http/static/values.js' {
  export function read(text: string): unknown;
  export function write(value: unknown): string;
  export function itemTexts(text: string): string[];
}

declare module '*/wires/http/static/widgets.js' {
  export const words: object;
}

declare module '*/wires/http/static/map.js' {
  export const mapWords: object;
}

declare module '*/wires/http/static/frames.js';
