import { useState, type SyntheticEvent } from 'react';

import { portType, wiresAt } from '../../model/ports';
import { portPath } from '../../model/types';
import { Fields, Section } from '../../panels/Fields';
import { useEditor } from '../../shell/contexts';
import { FindingTexts } from './FindingTexts';
import { PlaceForm } from './PlaceForm';
import { PropertyTable } from './PropertyTable';
import { SetEditor } from './SetEditor';
import type { DocumentComponent, Finding, Picture } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

interface Props {
  component: DocumentComponent; picture: Picture; findings: readonly Finding[]; document: OpenDocument;
  onConnect: (port: string) => void; onRemove: () => void;
}

/** A component of a document: name, whether it is required, ports with their wires, sets, properties. */
export function ComponentForm({ component, picture, findings, document, onConnect, onRemove }: Props) {
  const texts = useDocumentTexts();
  const { canChange, select, reveal } = useEditor();
  const [name, setName] = useState(component.name);
  const { id, origin } = component;
  const isFixed = !canChange || origin !== '';
  const rename = (event: SyntheticEvent) => {
    event.preventDefault();
    void document.edit({ do: 'rename', component: id, name }).then((after) => after && select([name]));
  };
  return (
    <>
      <h2>{component.name}</h2>
      {origin && <p className="remark">{texts.readOnlyPart(origin)}</p>}
      <FindingTexts findings={findings} />
      <form className="row" onSubmit={rename}>
        <label className="grow">{texts.name} <input type="text" value={name} disabled={isFixed} onChange={(event) => setName(event.target.value)} /></label>
        <button type="submit" disabled={isFixed || name === component.name || !name.trim()}>{texts.rename}</button>
      </form>
      <label className="check"><input type="checkbox" checked={component.is_required} disabled={isFixed} onChange={(event) => void document.edit({ do: 'require', component: id, is_required: event.target.checked })} />{texts.required2}</label>
      <div className="buttons"><button type="button" className="danger" disabled={isFixed} onClick={onRemove}>{texts.remove}</button></div>
      <Fields rows={[
        [texts.type, <span key="type" title={component.type_id}>{component.type}</span>], [texts.address, <code key="path">{component.path}</code>],
        [texts.source, component.source && <code key="source">{component.source}</code>], [texts.comment, component.description],
      ]} />
      <Section title={texts.standing} isOpen={false}><PlaceForm component={component} picture={picture} isFixed={isFixed} document={document} /></Section>
      <Section title={texts.portsTitle} count={component.ports.length}>
        <ul className="document-ports">
          {component.ports.map((port) => (
            <li key={port.name}>
              <p><strong>{port.name}</strong> <span className="note">{port.direction} · {portType(port)}</span>
                <button type="button" className="quiet" disabled={isFixed} aria-label={`${texts.connect} ${port.name}`} onClick={() => onConnect(portPath({ component: id, port: port.name }))}>{texts.connect}</button></p>
              {wiresAt(picture.connectors, id, port.name).map((wire) => {
                const far = wire.source.component === id && wire.source.port === port.name ? wire.target : wire.source;
                return (
                  <p key={wire.id} className="far">→ <button type="button" className="link" onClick={() => reveal(far.component)}>{far.component}:{far.port}</button>
                    <button type="button" className="quiet" disabled={!canChange} aria-label={`${texts.disconnect} ${far.component}:${far.port}`} onClick={() => void document.edit({ do: 'remove', components: [], connectors: [wire.id] })}>{texts.disconnect}</button></p>
                );
              })}
            </li>
          ))}
        </ul>
      </Section>
      <Section title={texts.configuration}><SetEditor component={component} isFixed={isFixed} document={document} /></Section>
      <Section title={texts.properties} count={Object.keys(component.properties).length} isOpen={false}>
        <PropertyTable values={component.properties} isFixed={isFixed} onChange={(key, value) => void document.edit({ do: 'state', component: id, key, value })} />
      </Section>
    </>
  );
}
