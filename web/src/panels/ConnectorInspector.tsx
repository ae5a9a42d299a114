import { useContext } from 'react';

import { endText, wireText } from '../model/does';
import type { System } from '../model/system';
import type { Connector } from '../model/types';
import { rateText } from '../parts/numbers';
import { RatesContext, useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { Fields, Section } from './Fields';
import { LazyValues } from './LazyValues';
import { Link } from './Link';
import { useVerbs } from './useVerbs';

export function ConnectorInspector({ system, wire }: { system: System; wire: Connector }) {
  const texts = useTexts();
  const { canChange } = useEditor();
  const { disconnect } = useVerbs();
  const rate = useContext(RatesContext).connectors[wire.id];
  const isData = system.components.get(wire.source.component)?.ports.some((port) => port.name === wire.source.port && port.direction === 'out');
  const properties = Object.entries(wire.properties);
  const twins = twinsOf(wire, system);
  return (
    <>
      <div className="headline"><h2>{wireText(wire)}</h2><p>{wire.name}</p></div>
      {wire.trouble && <p className="remark">{wire.trouble}</p>}
      <div className="buttons"><button type="button" className="danger" disabled={!canChange} onClick={() => disconnect([wire])}>{texts.act.disconnect}</button></div>
      {twins.length > 1 && (
        <>
          <p>{texts.manage.wires.between(twins.length)}</p>
          <ul className="links">{twins.map((one) => <li key={one.id}>{one.id === wire.id ? <strong>{one.name}</strong> : <Link id={one.id} text={one.name} />}</li>)}</ul>
          <div className="buttons"><button type="button" className="danger" disabled={!canChange} onClick={() => disconnect(twins)}>{texts.manage.wires.all}</button></div>
        </>
      )}
      <Fields rows={[
        [texts.inspector.source, <Link key="source" id={wire.source.component} text={endText(wire.source)} />],
        [texts.inspector.target, <Link key="target" id={wire.target.component} text={endText(wire.target)} />],
        [texts.inspector.rate, rateText(rate?.hz ?? null)],
        [texts.inspector.written, rate?.written ?? ''],
      ]} />
      {isData && <Section title={texts.inspector.values}><LazyValues end={wire.source} direction="out" wire={wire} /></Section>}
      <Section title={texts.inspector.properties} count={properties.length}>
        {properties.length ? <Fields rows={properties} /> : <p className="empty">{texts.inspector.noProperties}</p>}
      </Section>
    </>
  );
}

/** All connectors that run between the same two ports, this one too: in the diagram they lie side by side. */
function twinsOf({ source, target }: Connector, { connectors }: System): Connector[] {
  const isSame = (one: Connector['source'], other: Connector['source']) => one.component === other.component && one.port === other.port;
  return [...connectors.values()].filter((one) => isSame(one.source, source) && isSame(one.target, target));
}
