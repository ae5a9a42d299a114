import { Panel, useReactFlow } from '@xyflow/react';
import { useEffect } from 'react';

import { Icon } from '../parts/icons';
import { isTyping } from '../shell/useShortcuts';
import { useTexts } from '../texts';
import { FIT } from './graph';

/** Zoom and fit, by buttons and by the keys + − F. */
export function CanvasTools() {
  const texts = useTexts();
  const flow = useReactFlow();
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (isTyping(event) || event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === 'f') void flow.fitView(FIT);
      else if (event.key === '+' || event.key === '=') void flow.zoomIn();
      else if (event.key === '-') void flow.zoomOut();
    };
    addEventListener('keydown', onKey);
    return () => removeEventListener('keydown', onKey);
  }, [flow]);
  return (
    <Panel position="bottom-left" className="canvas-tools">
      <button type="button" aria-label={texts.bar.zoomIn} title={`${texts.bar.zoomIn} (+)`} onClick={() => void flow.zoomIn()}><Icon name="plus" /></button>
      <button type="button" aria-label={texts.bar.zoomOut} title={`${texts.bar.zoomOut} (−)`} onClick={() => void flow.zoomOut()}><Icon name="minus" /></button>
      <button type="button" aria-label={texts.bar.fit} title={`${texts.bar.fit} (F)`} onClick={() => void flow.fitView(FIT)}><Icon name="fit" /></button>
    </Panel>
  );
}
