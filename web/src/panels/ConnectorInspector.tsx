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

export function ConnectorInspector({ system, wire }: { system: Pick<System, 'components'>; wire: Connector }) {
  const texts = useTexts();
  const { canChange } = useEditor();
  const { disconnect } = useVerbs();
  const rate = useContext(RatesContext).connectors[wire.id];
  const isData = system.components.get(wire.source.component)?.ports.some((port) => port.name === wire.source.port && port.direction === 'out');
  const properties = Object.entries(wire.properties);
  return (
    <>
      <div className="headline"><h2>{wireText(wire)}</h2><p>{wire.name}</p></div>
      {wire.trouble && <p className="remark">{wire.trouble}</p>}
      <div className="buttons"><button type="button" className="danger" disabled={!canChange} onClick={() => disconnect([wire])}>{texts.act.disconnect}</button></div>
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
