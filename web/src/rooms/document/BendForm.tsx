import { useState } from 'react';

import { between } from '../../canvas/bends';
import type { Point } from '../../model/types';
import { Icon } from '../../parts/icons';
import type { DocumentConnector, Picture } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

/** The bend points of a connector as numbers, for who uses no mouse. */
export function BendForm({ connector, picture, isFixed, document }: { connector: DocumentConnector; picture: Picture; isFixed: boolean; document: OpenDocument }) {
  const texts = useDocumentTexts();
  const points = picture.bends[connector.id] ?? [];
  const bend = (next: readonly Point[]) => void document.edit({ do: 'bend', connector: connector.id, points: next.map(([x, y]) => ({ x, y })) });
  const ends = [connector.source, connector.target].map(({ component }): Point => {
    const at = picture.places[component] ?? picture.layout.boxes[component] ?? { x: 0, y: 0 };
    return [at.x, at.y];
  });
  const add = () => {
    const all = [ends[0] ?? [0, 0], ...points, ends[1] ?? [0, 0]] as Point[];
    bend([...points, between(all).at(-1) ?? [0, 0]]);
  };
  return (
    <div className="bend-form">
      {points.map(([x, y], index) => (
        <div key={`${index} ${x} ${y}`} className="row">
          <Coordinate label={texts.bendX(index + 1)} value={x} isFixed={isFixed} onChange={(to) => bend(points.map((one, at) => (at === index ? [to, y] : one)))} />
          <Coordinate label={texts.bendY(index + 1)} value={y} isFixed={isFixed} onChange={(to) => bend(points.map((one, at) => (at === index ? [x, to] : one)))} />
          <button type="button" className="quiet" disabled={isFixed} aria-label={texts.removeBend(index + 1)} title={texts.removeBend(index + 1)} onClick={() => bend(points.filter((_, at) => at !== index))}><Icon name="close" /></button>
        </div>
      ))}
      <button type="button" disabled={isFixed} onClick={add}>{texts.addBend}</button>
    </div>
  );
}

function Coordinate({ label, value, isFixed, onChange }: { label: string; value: number; isFixed: boolean; onChange: (to: number) => void }) {
  const [typed, setTyped] = useState(String(value));
  const take = () => Number.isFinite(Number(typed)) && typed.trim() !== '' && Number(typed) !== value && onChange(Number(typed));
  return <input type="number" aria-label={label} value={typed} disabled={isFixed} onChange={(event) => setTyped(event.target.value)} onBlur={take} onKeyDown={(event) => event.key === 'Enter' && take()} />;
}
