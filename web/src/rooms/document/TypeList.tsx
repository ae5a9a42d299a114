import { useEffect, useRef, useState, type KeyboardEvent } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { ComponentType } from './types';
import { useDocumentTexts } from './useDocument';

/** What a type that is dragged is carried as. */
export const TYPE_DATA = 'application/x-rtkit-type';

/** Component types of the granted folders: Enter adds one, or it is dragged into the diagram. */
export function TypeList({ onAdd }: { onAdd: (file: string) => void }) {
  const texts = useDocumentTexts();
  const { api, canChange } = useEditor();
  const [types, setTypes] = useState<readonly ComponentType[] | null>(null);
  const [problem, setProblem] = useState('');
  const [filter, setFilter] = useState('');
  const list = useRef<HTMLDivElement>(null);
  useEffect(() => {
    let isWanted = true;
    api.get<{ types: ComponentType[] }>('/api/documents/types').then(
      (found) => isWanted && setTypes(found.types), (error: unknown) => isWanted && setProblem(sentence(error)),
    );
    return () => {
      isWanted = false;
    };
  }, [api]);
  const shown = (types ?? []).filter((one) => `${one.name} ${one.category} ${one.vendor} ${one.description}`.toLowerCase().includes(filter.toLowerCase()));
  const go = (event: KeyboardEvent) => {
    const step = event.key === 'ArrowDown' ? 1 : event.key === 'ArrowUp' ? -1 : 0;
    if (!step) return;
    const buttons = [...(list.current?.querySelectorAll('button') ?? [])];
    const at = buttons.findIndex((one) => one === document.activeElement);
    const next = buttons[at + step];
    if (!next) return;
    event.preventDefault();
    next.focus();
  };
  return (
    <section className="document-types" aria-label={texts.types}>
      <h3>{texts.types} <span className="count">{types?.length ?? ''}</span></h3>
      <input type="search" aria-label={texts.typeFilter} placeholder={texts.typeFilter} value={filter} onChange={(event) => setFilter(event.target.value)} />
      <p className="note">{texts.typeHint}</p>
      {problem && <p className="error" role="alert">{problem}</p>}
      {types === null && !problem && <p className="empty">{texts.looking}</p>}
      {types?.length === 0 && <p className="empty">{texts.noTypes}</p>}
      <div className="rows" ref={list} onKeyDown={go} role="presentation">
        {shown.map((one) => (
          <button key={one.file} type="button" disabled={!canChange} draggable={canChange} title={`${one.id}\n${one.file}\n${one.description}`}
            onDragStart={(event) => event.dataTransfer.setData(TYPE_DATA, one.file)} onClick={() => onAdd(one.file)}>
            <strong>{one.name}</strong><span className="note">{one.category} · {one.version} · {texts.ports(one.ports)}</span>
          </button>
        ))}
      </div>
    </section>
  );
}
