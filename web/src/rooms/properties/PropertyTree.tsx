import { useMemo, useRef, useState, type KeyboardEvent } from 'react';

import { Icon } from '../../parts/icons';
import { useRoomTexts } from '../../texts';
import { propertiesTexts as en } from '../../texts/en/properties';
import { propertiesTexts as ja } from '../../texts/ja/properties';
import { rowsOf, type Owner, type Row } from './tree';

const MOST = 500;

interface Props {
  owners: readonly Owner[]; names: ReadonlyMap<string, readonly string[]>; load: (owner: string) => void;
  selected: string; onSelect: (target: string) => void;
}

/** All that has properties, and these below it. A click shows the page of a property. */
export function PropertyTree({ owners, names, load, selected, onSelect }: Props) {
  const texts = useRoomTexts({ en, ja });
  const [text, setText] = useState('');
  const [open, setOpen] = useState<ReadonlySet<string>>(new Set());
  const [focused, setFocused] = useState('');
  const list = useRef<HTMLDivElement>(null);
  const rows = useMemo(() => rowsOf(owners, names, open, text).slice(0, MOST), [owners, names, open, text]);
  const stop = [focused, selected].find((target) => rows.some((row) => row.target === target)) ?? rows[0]?.target;

  const toggle = (row: Row) => {
    if (row.level === 1) load(row.target);
    setOpen((before) => {
      const after = new Set(before);
      if (!after.delete(row.target)) after.add(row.target);
      return after;
    });
  };
  const search = (typed: string) => {
    // Names of services are few; those of components are known once one has looked there.
    if (typed) owners.filter((owner) => owner.kind === 'service').forEach((owner) => load(owner.target));
    setText(typed);
  };
  const onKeyDown = (event: KeyboardEvent, row: Row, index: number) => {
    const to = { ArrowDown: index + 1, ArrowUp: index - 1, Home: 0, End: rows.length - 1 }[event.key];
    if (to !== undefined) list.current?.querySelectorAll<HTMLElement>('[role=treeitem]')[to]?.focus();
    else if (event.key === 'Enter' || event.key === ' ') onSelect(row.target);
    else if (row.isBranch && event.key === (row.isOpen ? 'ArrowLeft' : 'ArrowRight')) toggle(row);
    else return;
    event.preventDefault();
  };
  return (
    <section className="panel tree" aria-label={texts.tree}>
      <div className="filters">
        <input type="search" aria-label={texts.search} placeholder={texts.search} value={text} onChange={(event) => search(event.target.value)} />
      </div>
      {rows.length === 0 && <p className="empty">{texts.nothingFound}</p>}
      <div role="tree" className="rows" aria-label={texts.tree} ref={list}>
        {rows.map((row, index) => (
          <div key={row.target} role="treeitem" aria-level={row.level} aria-selected={row.target === selected} title={row.target}
            aria-expanded={row.isBranch ? row.isOpen : undefined} tabIndex={row.target === stop ? 0 : -1} data-level={row.level}
            onFocus={() => setFocused(row.target)} onKeyDown={(event) => onKeyDown(event, row, index)} onClick={() => onSelect(row.target)}>
            {row.isBranch ? (
              // The arrow keys do the same: the sign is for the pointer only.
              // eslint-disable-next-line jsx-a11y/click-events-have-key-events, jsx-a11y/no-static-element-interactions
              <span className="twist" onClick={(event) => { event.stopPropagation(); toggle(row); }}><Icon name={row.isOpen ? 'open' : 'shut'} /></span>
            ) : <span className="twist" />}
            <span className="name">{row.name}</span>
            <span className="note">{row.note}</span>
          </div>
        ))}
      </div>
    </section>
  );
}
