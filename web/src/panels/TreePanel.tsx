import { memo, useMemo, useRef, useState, type KeyboardEvent } from 'react';

import type { Scope } from '../model/scope';
import { matches } from '../model/search';
import type { System } from '../model/system';
import { LOOKS, TROUBLED, type Component, type Look } from '../model/types';
import { StateIcon } from '../parts/StateIcon';
import { Icon } from '../parts/icons';
import { useEditor } from '../shell/contexts';
import type { Filter } from '../shell/view';
import { useTexts } from '../texts';
import { MoreFilters } from './MoreFilters';

interface Row { id: string; level: number; name: string; note: string; kind: 'manager' | 'process' | 'component'; look: Look | null; isTroubled: boolean }
type Records = Pick<System, 'managers' | 'processes' | 'components'>;
interface Props extends Records { shown: ReadonlySet<string> | null; scope: Scope; selection: readonly string[]; filter: Filter }

/** Managers, their slaves and their components. A click selects and brings it to the middle. */
export const TreePanel = memo(function TreePanel({ managers, processes, components, shown, scope, selection, filter }: Props) {
  const texts = useTexts();
  const { reveal, select, filter: setFilter } = useEditor();
  const [shut, setShut] = useState<ReadonlySet<string>>(new Set());
  const [focused, setFocused] = useState('');
  const list = useRef<HTMLDivElement>(null);
  const rows = useMemo(() => rowsOf({ managers, processes, components }, filter, shown, shut), [managers, processes, components, filter, shown, shut]);
  const tabStop = rows.some((row) => row.id === focused) ? focused : (rows.find((row) => selection.includes(row.id)) ?? rows[0])?.id;

  const toggle = (id: string) => setShut((before) => {
    const after = new Set(before);
    if (!after.delete(id)) after.add(id);
    return after;
  });
  const toggleSelected = (id: string) => select(selection.includes(id) ? selection.filter((one) => one !== id) : [...selection, id]);
  const onKeyDown = (event: KeyboardEvent, row: Row, index: number) => {
    const to = { ArrowDown: index + 1, ArrowUp: index - 1, Home: 0, End: rows.length - 1 }[event.key];
    const isBranch = row.kind !== 'component';
    if (to !== undefined) list.current?.querySelectorAll<HTMLElement>('[role=treeitem]')[to]?.focus();
    else if (event.key === ' ' && (event.ctrlKey || event.metaKey)) toggleSelected(row.id);
    else if (event.key === 'Enter' || event.key === ' ') reveal(row.id);
    else if (event.key === 'ArrowLeft' && isBranch && !shut.has(row.id)) toggle(row.id);
    else if (event.key === 'ArrowRight' && shut.has(row.id)) toggle(row.id);
    else return;
    event.preventDefault();
  };

  return (
    <section className="panel tree" aria-labelledby="tree-title">
      <h2 id="tree-title" className="unseen">{texts.tree.title}</h2>
      <div className="filters">
        <input type="search" aria-label={texts.tree.filter} placeholder={texts.tree.filter} value={filter.text}
          onChange={(event) => setFilter({ ...filter, text: event.target.value })} />
        <select aria-label={texts.tree.filterState} value={filter.look} onChange={(event) => setFilter({ ...filter, look: event.target.value as Filter['look'] })}>
          <option value="all">{texts.tree.all}</option>
          <option value="troubled">{texts.tree.troubled}</option>
          {LOOKS.map((look) => <option key={look} value={look}>{texts.looks[look]}</option>)}
        </select>
        <MoreFilters managers={managers} components={components} filter={filter} scope={scope} />
      </div>
      {rows.length === 0 && <p className="empty">{texts.tree.none}</p>}
      <div role="tree" aria-multiselectable="true" className="rows" aria-label={texts.tree.title} ref={list}>
        {rows.map((row, index) => (
          <div key={`${row.kind} ${row.id}`} role="treeitem" aria-level={row.level} aria-selected={selection.includes(row.id)}
            aria-expanded={row.kind === 'component' ? undefined : !shut.has(row.id)} tabIndex={row.id === tabStop ? 0 : -1}
            className={`is-${row.kind} ${row.isTroubled ? 'is-troubled' : ''}`} title={row.id}
            onFocus={() => setFocused(row.id)} onKeyDown={(event) => onKeyDown(event, row, index)}
            onClick={(event) => (event.ctrlKey || event.metaKey ? toggleSelected(row.id) : reveal(row.id))}>
            {row.look ? <StateIcon look={row.look} /> : (
              // The arrow keys do the same: the sign is for the pointer only.
              // eslint-disable-next-line jsx-a11y/click-events-have-key-events, jsx-a11y/no-static-element-interactions
              <span className="twist" onClick={(event) => { event.stopPropagation(); toggle(row.id); }}><Icon name={shut.has(row.id) ? 'shut' : 'open'} /></span>
            )}
            <span className="name">{row.name}</span>
            <span className="note">{row.note}</span>
          </div>
        ))}
      </div>
    </section>
  );
});

const { compare } = new Intl.Collator('en', { numeric: true });
const byName = (one: Component, other: Component): number => compare(one.name, other.name);

/** The visible rows in order; a branch without a match inside is left out. */
function rowsOf({ managers, processes, components }: Records, filter: Filter, shown: ReadonlySet<string> | null, shut: ReadonlySet<string>): Row[] {
  const isFiltered = filter.text !== '' || filter.look !== 'all' || filter.kind !== 'all' || shown !== null;
  const fits = ({ id, name, type, look, word, remark, is_composite }: Component) =>
    (!shown || shown.has(id)) && (filter.kind === 'all' || filter.kind === (is_composite ? 'composite' : 'component')) &&
    matches(`${name} ${type} ${word} ${remark} ${id}`, filter.text) &&
    (filter.look === 'all' || (filter.look === 'troubled' ? TROUBLED.has(look) : filter.look === look));
  const inside = new Map<string, Component[]>();
  for (const one of [...components.values()].filter(fits).sort(byName)) inside.set(one.process, [...(inside.get(one.process) ?? []), one]);
  const leaves = (process: string, level: number): Row[] => (inside.get(process) ?? []).map((one) => ({
    id: one.id, level, name: one.name, note: one.word, kind: 'component', look: one.look, isTroubled: TROUBLED.has(one.look),
  }));
  const isBranchWanted = ({ kind, name }: Row) => filter.kind === (kind === 'process' ? 'slave' : kind) && matches(name, filter.text);
  const branch = (row: Row, below: Row[]): Row[] => (isFiltered && !below.length && !isBranchWanted(row) ? [] : shut.has(row.id) ? [row] : [row, ...below]);
  return [...managers.values()].flatMap((manager) => {
    const own = [...processes.values()].filter((one) => one.manager === manager.id);
    const slaves = own.filter((one) => one.id !== manager.id).flatMap((one) => branch(
      { id: one.id, level: 2, name: one.name, note: one.state === 'up' ? '' : one.state, kind: 'process', look: null, isTroubled: one.state === 'lost' || one.state === 'silent' },
      leaves(one.id, 3),
    ));
    const note = manager.state === 'up' ? manager.host : manager.state;
    const row: Row = { id: manager.id, level: 1, name: manager.name, note, kind: 'manager', look: null, isTroubled: manager.state === 'gone' };
    return branch(row, [...leaves(manager.id, 2), ...slaves]);
  });
}
