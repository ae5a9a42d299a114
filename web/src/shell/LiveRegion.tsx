import { useEffect, useRef, useState } from 'react';

import type { Component } from '../model/types';
import { TROUBLED } from '../model/types';
import { useTexts } from '../texts';

/** Readers would drown in more. */
const PAUSE_MS = 1000;
const NAMED = 3;

/** Tells readers of screens which states have changed: at most once a second, troubles at once. */
export function LiveRegion({ components, isKnown }: { components: ReadonlyMap<string, Component>; isKnown: boolean }) {
  const texts = useTexts();
  const before = useRef<ReadonlyMap<string, Component> | null>(null);
  const waiting = useRef<string[]>([]);
  const [polite, setPolite] = useState('');
  const [urgent, setUrgent] = useState('');
  useEffect(() => {
    if (!isKnown) return;
    const old = before.current;
    before.current = components;
    if (!old) return;
    const bad: string[] = [];
    for (const component of components.values()) {
      const was = old.get(component.id);
      if (was?.look === component.look) continue;
      const text = texts.live.became(component.name, component.word);
      if (TROUBLED.has(component.look)) bad.push(component.remark ? `${text}. ${component.remark}` : text);
      else waiting.current.push(text);
    }
    for (const component of old.values()) if (!components.has(component.id)) waiting.current.push(texts.live.gone(component.name));
    if (!bad.length) return;
    setTimeout(() => setUrgent(summed(bad, texts.live.more)));
  }, [components, isKnown, texts]);
  useEffect(() => {
    const timer = setInterval(() => {
      if (!waiting.current.length) return;
      setPolite(summed(waiting.current, texts.live.more));
      waiting.current = [];
    }, PAUSE_MS);
    return () => clearInterval(timer);
  }, [texts]);
  return (
    <>
      <p className="unseen" aria-live="polite">{polite}</p>
      <p className="unseen" aria-live="assertive">{urgent}</p>
    </>
  );
}

function summed(lines: string[], more: (count: number) => string): string {
  const shown = lines.slice(0, NAMED);
  return [...shown, ...(lines.length > NAMED ? [more(lines.length - NAMED)] : [])].join('; ');
}
