import { useId, useState, type KeyboardEvent } from 'react';

import { portType } from '../model/ports';
import { score } from '../model/search';
import type { System } from '../model/system';
import { Modal } from '../parts/Modal';
import { useTexts } from '../texts';
import { useEditor } from './contexts';
import { usePaletteActions, type PaletteGiven } from './usePaletteActions';

/** Something that the palette can do: a name to find it by, and what happens on Enter. */
export interface Command { kind: 'action' | 'component' | 'port' | 'type' | 'manager'; name: string; note: string; run: () => void }

const SHOWN = 40;

/** Finds components, ports, types and actions by a few letters. */
export function Palette({ system, given }: { system: System; given: PaletteGiven }) {
  const texts = useTexts();
  const { open, reveal, select } = useEditor();
  const [query, setQuery] = useState('');
  const [current, setCurrent] = useState(0);
  const id = useId();
  const actions = usePaletteActions(given);
  const found = [...actions, ...commandsOf(system, reveal, select)]
    .map((command) => ({ command, points: score(command.name, query) * 2 || score(`${command.name} ${command.note}`, query) }))
    .filter(({ points }) => points > 0).sort((a, b) => b.points - a.points).slice(0, SHOWN).map(({ command }) => command);
  const at = Math.min(current, found.length - 1);
  const run = (command: Command | undefined) => {
    if (!command) return;
    open(null);
    command.run();
  };
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.key === 'ArrowDown') setCurrent((at + 1) % Math.max(found.length, 1));
    else if (event.key === 'ArrowUp') setCurrent((at - 1 + found.length) % Math.max(found.length, 1));
    else if (event.key === 'Enter') run(found[at]);
    else return;
    event.preventDefault();
  };
  return (
    <Modal title={texts.palette.title} className="palette" onClose={() => open(null)}>
      {/* eslint-disable-next-line jsx-a11y/no-autofocus -- The dialog opens for this field. */}
      <input type="text" autoFocus role="combobox" aria-expanded="true" aria-controls={`${id}-list`} aria-autocomplete="list" aria-activedescendant={found.length ? `${id}-${at}` : undefined}
        aria-label={texts.palette.placeholder} placeholder={texts.palette.placeholder} value={query} onKeyDown={onKeyDown}
        onChange={(event) => { setQuery(event.target.value); setCurrent(0); }} />
      <div role="listbox" className="rows" id={`${id}-list`} aria-label={texts.palette.title}>
        {found.map((command, index) => (
          // The field above has the focus and the keys; the pointer is another way.
          // eslint-disable-next-line jsx-a11y/click-events-have-key-events
          <div key={`${command.kind} ${command.name} ${command.note}`} id={`${id}-${index}`} role="option" aria-selected={index === at} tabIndex={-1}
            ref={(row) => { if (index === at) row?.scrollIntoView({ block: 'nearest' }); }} onClick={() => run(command)}>
            <span className="kind">{texts.palette.kinds[command.kind]}</span>{command.name}<span className="note">{command.note}</span>
          </div>
        ))}
      </div>
      <p className="empty">{found.length ? texts.palette.hint : texts.palette.none}</p>
    </Modal>
  );
}

function commandsOf(system: System, reveal: (id: string) => void, select: (ids: string[]) => void): Command[] {
  const components = [...system.components.values()];
  const types = new Map<string, string[]>();
  for (const one of components) types.set(one.type, [...(types.get(one.type) ?? []), one.id]);
  return [
    ...components.map((one): Command => ({ kind: 'component', name: one.name, note: `${one.type}, ${one.word}`, run: () => reveal(one.id) })),
    ...components.flatMap((one) => one.ports.map((port): Command => ({ kind: 'port', name: `${one.name}:${port.name}`, note: portType(port), run: () => reveal(one.id) }))),
    ...[...types].map(([type, ids]): Command => ({ kind: 'type', name: type, note: String(ids.length), run: () => (ids.length === 1 && ids[0] ? reveal(ids[0]) : select(ids)) })),
    ...[...system.managers.values()].map((one): Command => ({ kind: 'manager', name: one.name, note: one.host, run: () => reveal(one.id) })),
  ];
}
