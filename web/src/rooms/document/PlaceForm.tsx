import { useState, type SyntheticEvent } from 'react';

import { DIRECTIONS, type Direction, type DocumentComponent, type Picture } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

const FIELDS = ['x', 'y', 'width', 'height'] as const;
type Typed = Partial<Record<(typeof FIELDS)[number], string>>;

/** Where a box stands, how large it is, and where its out ports point: as numbers, for who uses no mouse. What the profile leaves open is as it is drawn. */
export function PlaceForm({ component, picture, isFixed, document }: { component: DocumentComponent; picture: Picture; isFixed: boolean; document: OpenDocument }) {
  const texts = useDocumentTexts();
  const [typed, setTyped] = useState<Typed>({});
  const { id } = component;
  const [box, standing] = [picture.layout.boxes[id], picture.places[id]];
  if (!box) return null;
  const known = { x: standing?.x ?? box.x, y: standing?.y ?? box.y, width: Math.max(standing?.width ?? 0, box.width), height: Math.max(standing?.height ?? 0, box.height) };
  const now = (field: (typeof FIELDS)[number]) => Number(typed[field] ?? known[field]);
  const isMoved = now('x') !== known.x || now('y') !== known.y;
  const isSized = now('width') !== known.width || now('height') !== known.height;
  const apply = async (event: SyntheticEvent) => {
    event.preventDefault();
    if (isMoved && !(await document.edit({ do: 'move', places: { [id]: { x: now('x'), y: now('y') } } }))) return;
    if (isSized && !(await document.edit({ do: 'resize', component: id, width: now('width'), height: now('height') }))) return;
    setTyped({});
  };
  return (
    <form className="place-form" onSubmit={(event) => void apply(event)}>
      {FIELDS.map((field) => (
        <label key={field}>{texts.box[field]} <input type="number" value={typed[field] ?? String(known[field])} disabled={isFixed} onChange={(event) => setTyped((before) => ({ ...before, [field]: event.target.value }))} /></label>
      ))}
      <label>{texts.direction} <select value={standing?.direction ?? 'RIGHT'} disabled={isFixed} onChange={(event) => void document.edit({ do: 'turn', component: id, direction: event.target.value as Direction })}>
        {DIRECTIONS.map((one) => <option key={one} value={one}>{texts.directions[one]}</option>)}
      </select></label>
      {(isMoved || isSized) && <button type="submit" className="primary" disabled={isFixed}>{texts.apply}</button>}
    </form>
  );
}
