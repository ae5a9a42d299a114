import { useEffect, useRef } from 'react';

import type { System } from '../../model/system';
import { ComponentForm } from './ComponentForm';
import { ConnectorForm } from './ConnectorForm';
import { ProfileForm } from './ProfileForm';
import type { Picture } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

interface Props {
  picture: Picture; system: System; selection: readonly string[]; document: OpenDocument; focusCount: number;
  onConnect: (port: string) => void; onRemove: () => void;
}

/** What is selected in a document; what the profile tells of itself when nothing is. */
export function DocumentInspector({ picture, system, selection, document, focusCount, onConnect, onRemove }: Props) {
  const texts = useDocumentTexts();
  const ref = useRef<HTMLElement>(null);
  useEffect(() => {
    if (focusCount) ref.current?.focus();
  }, [focusCount]);
  const known = selection.filter((id) => system.components.has(id) || system.connectors.has(id));
  const [id] = known;
  const component = picture.components.find((one) => one.id === id);
  const connector = picture.connectors.find((one) => one.id === id);
  const findings = picture.findings.filter((one) => one.on === id);
  return (
    <section className="document-inspector" aria-label={texts.inspector} tabIndex={-1} ref={ref}>
      {known.length > 1 ? (
        <><h2>{texts.several(known.length)}</h2><button type="button" className="danger" onClick={onRemove}>{texts.remove}</button></>
      ) : component ? (
        <ComponentForm key={component.id} component={component} picture={picture} findings={findings} document={document} onConnect={onConnect} onRemove={onRemove} />
      ) : connector ? (
        <ConnectorForm key={connector.id} connector={connector} findings={findings} document={document} picture={picture} onRemove={onRemove} />
      ) : <ProfileForm key={picture.id} picture={picture} document={document} />}
    </section>
  );
}
