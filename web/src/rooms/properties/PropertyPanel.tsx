import { useEffect, useRef } from 'react';

import { useRoomTexts } from '../../texts';
import { propertiesTexts as en } from '../../texts/en/properties';
import { propertiesTexts as ja } from '../../texts/ja/properties';
import type { Values } from './useProperties';
import { createPanel, speak, type Gui, type PanelElement, type Source } from './widgets';

/** The widgets of a page: the custom elements of the panels of services. They are drawn by themselves, not by React. */
export function PropertyPanel({ gui, source, values, isLost }: { gui: Gui; source: Source; values: Values; isLost: boolean }) {
  const texts = useRoomTexts({ en, ja });
  const host = useRef<HTMLDivElement>(null);
  const panel = useRef<PanelElement>(null);
  useEffect(() => {
    speak(texts);
    panel.current = createPanel();
    host.current?.append(panel.current);
    return () => panel.current?.remove();
  }, [texts]);
  useEffect(() => {
    const focused = document.activeElement?.closest<HTMLElement>('[data-name]')?.dataset['name'];
    panel.current?.redraw(gui, source);
    values.forEach((name, text, told) => panel.current?.show(name, text, told));
    if (focused && !host.current?.contains(document.activeElement)) {
      const parts = ':is(input, textarea, select, button, [tabindex])';
      host.current?.querySelector<HTMLElement>(`[data-name="${CSS.escape(focused)}"] ${parts}`)?.focus();
    }
  }, [gui, source, values, texts]);
  useEffect(() => values.listen((name, text, told) => panel.current?.show(name, text, told)), [values]);
  useEffect(() => panel.current?.lock(isLost), [isLost, gui]);
  return <div ref={host} className="widgets" />;
}
