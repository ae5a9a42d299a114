import { useContext, type ReactNode } from 'react';

import { endText, farEnds } from '../model/does';
import { portType, shortName } from '../model/ports';
import { matches } from '../model/search';
import type { System } from '../model/system';
import type { Component, Connector, Port } from '../model/types';
import { StateIcon } from '../parts/StateIcon';
import { rateText } from '../parts/numbers';
import { RatesContext, useEditor } from '../shell/contexts';
import type { Filter } from '../shell/view';
import { useTexts } from '../texts';
import { Link } from './Link';
import { RightsGate } from './RightsGate';
import { VerbButtons } from './VerbButtons';
import { useVerbs } from './useVerbs';

/** More rows make the page slow and help nobody: the filter narrows them. */
const SHOWN = 300;

/** The twin of the diagram: the same components, ports and connectors as tables, with the same actions. */
export function TableView({ system, filter: shown }: { system: System; filter: Filter }) {
  const texts = useTexts();
  const filter = shown.text;
  const { filter: setFilter } = useEditor();
  const components = [...system.components.values()];
  const ports = components.flatMap((component) => component.ports.map((port) => ({ component, port })));
  const words = texts.table;
  return (
    <main className="tables" aria-label={words.label}>
      <input type="search" aria-label={words.filter} placeholder={words.filter} value={filter} onChange={(event) => setFilter({ ...shown, text: event.target.value })} />
      <Table title={words.components} heads={[words.name, words.type, words.state, words.remark, words.process, words.actions]}
        rows={components.filter((one) => matches(`${one.id} ${one.type} ${one.word} ${one.remark}`, filter))}
        row={(one) => <RightsGate key={one.id} system={system} ids={[one.id]}><ComponentRow component={one} /></RightsGate>} />
      <Table title={words.ports} heads={[words.component, words.port, words.direction, words.type, words.connected, words.actions]}
        rows={ports.filter(({ component, port }) => matches(`${component.id} ${port.name} ${portType(port)}`, filter))}
        row={({ component, port }) => <RightsGate key={`${component.id}:${port.name}`} system={system} ids={[component.id]}><PortRow system={system} component={component} port={port} /></RightsGate>} />
      <Table title={words.connectors} heads={[words.name, words.source, words.target, words.rate, words.trouble, words.actions]}
        rows={[...system.connectors.values()].filter((one) => matches(`${one.name} ${endText(one.source)} ${endText(one.target)} ${one.trouble}`, filter))}
        row={(one) => <RightsGate key={one.id} system={system} ids={[one.id]}><WireRow wire={one} /></RightsGate>} />
    </main>
  );
}

function Table<T>({ title, heads, rows, row }: { title: string; heads: string[]; rows: T[]; row: (one: T) => ReactNode }) {
  const texts = useTexts();
  return (
    <table>
      <caption>{title} <span className="count">{rows.length}</span></caption>
      <thead><tr>{heads.map((head) => <th key={head} scope="col">{head}</th>)}</tr></thead>
      <tbody>
        {rows.slice(0, SHOWN).map(row)}
        {rows.length === 0 && <tr><td colSpan={heads.length} className="empty">{texts.table.noRows}</td></tr>}
        {rows.length > SHOWN && <tr><td colSpan={heads.length} className="empty">{texts.table.more(rows.length - SHOWN)}</td></tr>}
      </tbody>
    </table>
  );
}

function ComponentRow({ component }: { component: Component }) {
  return (
    <tr>
      <th scope="row"><Link id={component.id} text={component.name} /></th>
      <td>{component.type}</td>
      <td className={`look-${component.look}`}><StateIcon look={component.look} /> {component.word}</td>
      <td>{component.remark}</td>
      <td><Link id={component.process} /></td>
      <td><VerbButtons components={[component]} /></td>
    </tr>
  );
}

function PortRow({ system, component, port }: { system: System; component: Component; port: Port }) {
  const texts = useTexts();
  const { canChange, open } = useEditor();
  const from = { component: component.id, port: port.name };
  return (
    <tr>
      <th scope="row"><Link id={component.id} text={component.name} /></th>
      <td>{port.name}</td>
      <td>{texts.directions[port.direction]}</td>
      <td>{portType(port)}</td>
      <td>{farEnds(system, component.id, port.name).map(({ wire, far }) => <Link key={wire.id} id={wire.id} text={endText(far)} />)}</td>
      <td><button type="button" disabled={!canChange} onClick={() => open({ kind: 'connect', from, to: null, component: component.id })}>{texts.act.connect}</button></td>
    </tr>
  );
}

function WireRow({ wire }: { wire: Connector }) {
  const texts = useTexts();
  const { canChange } = useEditor();
  const { disconnect } = useVerbs();
  const hz = useContext(RatesContext).connectors[wire.id]?.hz ?? null;
  return (
    <tr>
      <th scope="row"><Link id={wire.id} text={wire.name || shortName(wire.id)} /></th>
      <td>{endText(wire.source)}</td>
      <td>{endText(wire.target)}</td>
      <td className="number">{rateText(hz)}</td>
      <td>{wire.trouble && <span className="warning">⚠ {wire.trouble}</span>}</td>
      <td><button type="button" disabled={!canChange} onClick={() => disconnect([wire])}>{texts.act.disconnect}</button></td>
    </tr>
  );
}
