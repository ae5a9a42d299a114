import { useState, type SyntheticEvent } from 'react';

import { ConnectorOptions } from '../../actions/ConnectorOptions';
import { badLine, propertiesOf, wishOf } from '../../model/connecting';
import { Modal } from '../../parts/Modal';
import type { DocumentConnector } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

/** How the values of a connector travel: the form of what lives, for a connector of a document. */
export function OptionsDialog({ connector, document, onClose }: { connector: DocumentConnector; document: OpenDocument; onClose: () => void }) {
  const texts = useDocumentTexts();
  const [first] = useState(() => wishOf(connector.properties));
  const [wish, setWish] = useState(first);
  const wrongLine = badLine(wish.further);
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (wrongLine !== null) return;
    const [before, after] = [propertiesOf(first), propertiesOf(wish)];
    const properties = Object.fromEntries([...new Set([...Object.keys(before), ...Object.keys(after)])].filter((key) => before[key] !== after[key]).map((key) => [key, after[key] ?? null]));
    onClose();
    if (Object.keys(properties).length) void document.edit({ do: 'connector', connector: connector.id, properties });
  };
  return (
    <Modal title={texts.options} className="connect" onClose={onClose}>
      <form method="dialog" onSubmit={submit}>
        <ConnectorOptions wish={wish} onChange={setWish} wrongLine={wrongLine} />
        <footer>
          <button type="button" onClick={onClose}>{texts.cancel}</button>
          <button type="submit" className="primary" disabled={wrongLine !== null}>{texts.apply}</button>
        </footer>
      </form>
    </Modal>
  );
}
