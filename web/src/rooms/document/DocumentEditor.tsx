import { useMemo, useRef, useState, type DragEvent } from 'react';

import { Canvas } from '../../canvas/Canvas';
import type { Component, PortEnd, Rates } from '../../model/types';
import { portPath } from '../../model/types';
import { Modal } from '../../parts/Modal';
import { EditorContext, RatesContext } from '../../shell/contexts';
import { useShortcuts } from '../../shell/useShortcuts';
import { ConnectPort } from './ConnectPort';
import { DocumentBar } from './DocumentBar';
import { DocumentInspector } from './DocumentInspector';
import { FindingList } from './FindingList';
import { SaveDialog } from './SaveDialog';
import { TypeList, TYPE_DATA } from './TypeList';
import { fresh, layoutOf, systemOf } from './picture';
import type { Place } from './types';
import { useDiagram } from './useDiagram';
import { useDocument, useDocumentTexts, type OpenDocument } from './useDocument';

const NO_RATES: Rates = { connectors: {}, components: {} };

/** One document: its diagram, the types that can be added, what is selected, and what the checks find. */
export function DocumentEditor({ of }: { of: string }) {
  const texts = useDocumentTexts();
  const document = useDocument(of);
  const { view, editor, bends } = useDiagram(document);
  const [from, setFrom] = useState<string | null>(null);
  const [isSaving, setSaving] = useState(false);
  const [focusCount, setFocusCount] = useState(0);
  const stage = useRef<HTMLDivElement>(null);
  const { picture, edit } = document;
  const system = useMemo(() => picture && systemOf(picture, texts), [picture, texts]);
  const layout = useMemo(() => picture && layoutOf({ ...picture, bends: { ...picture.bends, ...Object.fromEntries([...bends].map(([id, points]) => [id, [...points]])) } }), [picture, bends]);
  const { canChange } = editor;

  const add = async (file: string, at?: Place) => {
    const after = await edit({ do: 'add', type: file, ...(at && { at }) });
    const id = picture && after ? fresh(picture, after) : undefined;
    if (id) editor.reveal(id);
  };
  const connect = (source: PortEnd, target: PortEnd) => void edit({ do: 'connect', source: portPath(source), target: portPath(target) });
  const remove = () => {
    const [components, connectors] = [view.selection.filter((id) => system?.components.has(id)), view.selection.filter((id) => system?.connectors.has(id))];
    if (canChange && components.length + connectors.length) void edit({ do: 'remove', components, connectors }).then((done) => done && editor.select([]));
  };
  const firstPort = (component: Component | undefined) => {
    const port = component?.ports[0];
    if (component && port && canChange) setFrom(portPath({ component: component.id, port: port.name }));
  };
  useShortcuts({
    undo: () => canChange && void document.move('undo'),
    redo: () => canChange && void document.move('redo'),
    remove,
    connect: () => firstPort(system?.components.get(view.selection[0] ?? '')),
    all: () => editor.select([...(system?.components.keys() ?? [])]),
    clear: () => editor.select([]),
  });
  const onDrop = (event: DragEvent) => {
    const file = event.dataTransfer.getData(TYPE_DATA);
    if (!file || !canChange) return;
    event.preventDefault();
    void add(file, placeOf(event, stage.current));
  };

  if (!picture || !system || !layout) return <Waiting document={document} />;
  return (
    <EditorContext value={editor}>
      <RatesContext value={NO_RATES}>
        <main className="room document" aria-label={picture.name}>
          <DocumentBar picture={picture} document={document} onSaveAs={() => setSaving(true)} />
          <TypeList onAdd={(file) => void add(file)} />
          <div className="document-stage" role="presentation" ref={stage} onDragOver={(event) => event.dataTransfer.types.includes(TYPE_DATA) && event.preventDefault()} onDrop={onDrop}>
            {system.components.size > 0
              ? <Canvas system={system} shown={null} layout={layout} view={view} onOpen={() => setFocusCount((count) => count + 1)} onConnect={connect} />
              : <p className="empty">{texts.emptyDiagram}</p>}
          </div>
          <DocumentInspector picture={picture} system={system} selection={view.selection} document={document} focusCount={focusCount} onConnect={setFrom} onRemove={remove} />
          <FindingList picture={picture} />
          <p className="unseen" role="status">{document.done}</p>
        </main>
        {from !== null && <ConnectPort system={system} from={from} onFrom={setFrom} onClose={() => setFrom(null)} onConnect={(source, target) => { setFrom(null); void edit({ do: 'connect', source, target }); }} />}
        {document.asks && (
          <Modal title={texts.replaceVariables} onClose={() => document.answer(false)}>
            <p>{texts.replaceHint}</p>
            <ul>{document.asks.map((text) => <li key={text}><code>{text}</code></li>)}</ul>
            <footer>
              <button type="button" onClick={() => document.answer(false)}>{texts.cancel}</button>
              <button type="button" className="danger filled" onClick={() => document.answer(true)}>{texts.replaceThem}</button>
            </footer>
          </Modal>
        )}
        {isSaving && <SaveDialog picture={picture} save={document.save} onClose={() => setSaving(false)} />}
      </RatesContext>
    </EditorContext>
  );
}

function Waiting({ document }: { document: OpenDocument }) {
  const texts = useDocumentTexts();
  return <main className="room documents">{document.problem ? <p className="error" role="alert">{document.problem}</p> : <p className="empty">{texts.opening}</p>}</main>;
}

/** Where in the diagram something was dropped. */
function placeOf(event: DragEvent, stage: HTMLElement | null): Place {
  const pane = stage?.querySelector('.react-flow__viewport');
  const frame = stage?.querySelector('.react-flow')?.getBoundingClientRect();
  if (!pane || !frame) return { x: 0, y: 0 };
  const { a: zoom, e: left, f: top } = new DOMMatrixReadOnly(getComputedStyle(pane).transform);
  return { x: Math.round((event.clientX - frame.left - left) / zoom), y: Math.round((event.clientY - frame.top - top) / zoom) };
}
