import { cleanup } from '@testing-library/react';
import { afterEach } from 'vitest';

afterEach(cleanup);

// jsdom knows dialogs, but not how to open them.
Object.assign(HTMLDialogElement.prototype, {
  showModal(this: HTMLDialogElement) {
    this.open = true;
  },
  close(this: HTMLDialogElement) {
    this.open = false;
  },
});

// Nor does it scroll, or know media queries.
Object.assign(Element.prototype, { scrollIntoView: () => undefined });
Object.assign(globalThis, { matchMedia: () => ({ matches: false }) });
