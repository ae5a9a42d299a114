import { useState } from 'react';

import { Fields, Section } from '../../panels/Fields';
import { useEditor } from '../../shell/contexts';
import { BendForm } from './BendForm';
import { FindingTexts } from './FindingTexts';
import { OptionsDialog } from './OptionsDialog';
import { PropertyTable } from './PropertyTable';
import type { DocumentConnector, Finding, Picture } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

interface Props { connector: DocumentConnector; findings: readonly Finding[]; document: OpenDocument; picture: Picture; onRemove: () => void }

/** A connector of a document: its ends, how it carries values, its properties. */
export function ConnectorForm({ connector, findings, document, picture, onRemove }: Props) {
  const texts = useDocumentTexts();
  const { canChange, reveal } = useEditor();
  const isFixed = !canChange || connector.origin !== '';
  const [isChoosing, setChoosing] = useState(false);
  const { source, target } = connector;
  return (
    <>
      <h2>{connector.name || connector.id}</h2>
      {connector.origin && <p className="remark">{texts.readOnlyPart(connector.origin)}</p>}
      <FindingTexts findings={findings} />
      <Fields rows={[
        [texts.ends, <span key="ends">{[source, target].map((end, index) => <button key={index} type="button" className="link" onClick={() => reveal(end.component)}>{end.component}:{end.port}</button>)}</span>],
        [texts.data, connector.data_type], [texts.how, [connector.interface_type, connector.dataflow_type, connector.subscription_type].filter(Boolean).join(', ')],
      ]} />
      <div className="buttons">
        {connector.data_type !== undefined && <button type="button" disabled={isFixed} onClick={() => setChoosing(true)}>{texts.options}</button>}
        <button type="button" className="danger" disabled={isFixed} onClick={onRemove}>{texts.disconnect}</button></div>
      {isChoosing && <OptionsDialog connector={connector} document={document} onClose={() => setChoosing(false)} />}
      <Section title={texts.bends} count={picture.bends[connector.id]?.length ?? 0}><BendForm connector={connector} picture={picture} isFixed={isFixed} document={document} /></Section>
      <Section title={texts.properties} count={Object.keys(connector.properties).length}>
        <PropertyTable values={connector.properties} isFixed={isFixed} onChange={(key, value) => void document.edit({ do: 'connector', connector: connector.id, properties: { [key]: value } })} />
      </Section>
    </>
  );
}
