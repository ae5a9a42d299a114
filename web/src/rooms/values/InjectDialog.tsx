import { useEffect, useId, useState } from 'react';

import { firstText, literalOf, type Field, type Typed } from '../../model/inject';
import { endText } from '../../model/does';
import { portEnd } from '../../model/types';
import { Modal } from '../../parts/Modal';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useValuesTexts } from './useValuesTexts';

interface PortType { type: string; fields: Field[]; why: string }

/** While one types, the server is asked once for each pause. */
const PAUSE_MS = 250;

/** Writes one value to an in port: a field for each part of its type, and the literal that `rtinject` gets. */
export function InjectDialog({ port, onClose }: { port: string; onClose: () => void }) {
  const texts = useValuesTexts();
  const { api, perform } = useEditor();
  const [type, setType] = useState<PortType | null>(null);
  const [problem, setProblem] = useState('');
  const [typed, setTyped] = useState<Typed>({});
  const [literal, setLiteral] = useState('');
  const name = endText(portEnd(port));
  useEffect(() => {
    api.get<PortType>(`/api/port?port=${encodeURIComponent(port)}`).then((found) => {
      setType(found);
      if (found.fields.length) setLiteral(literalOf(found.fields, {}));
    }, (error: unknown) => setProblem(sentence(error)));
  }, [api, port]);
  const why = useMisfit(port, literal);
  const change = (field: string, text: string) => {
    const next = { ...typed, [field]: text };
    setTyped(next);
    setLiteral(literalOf(type?.fields ?? [], next));
  };
  const send = () => {
    onClose();
    void perform([{ do: 'inject', port, value: literal }], texts.injected(literal, name));
  };
  return (
    <Modal title={texts.injectTitle(name)} className="inject" onClose={onClose}>
      <form className="grid" onSubmit={(event) => { event.preventDefault(); if (why === '') send(); }}>
        {!type && !problem && <p className="empty">{texts.asking}</p>}
        {type && <p className="type"><code>{type.type}</code></p>}
        {type?.why && <p>{texts.unknown(type.why)}</p>}
        {type?.fields.map((field) => <FieldInput key={field.name} field={field} text={typed[field.name] ?? firstText(field)} onChange={(text) => change(field.name, text)} />)}
        <label>{texts.literal}<input type="text" className="literal" spellCheck={false} value={literal} onChange={(event) => setLiteral(event.target.value)} /></label>
        <p role="status" className={why ? 'bad' : ''}>{problem || (why === null ? texts.checking : why || texts.fits)}</p>
        <footer><button type="button" onClick={onClose}>{texts.cancel}</button><button type="submit" className="primary" disabled={why !== ''}>{texts.go}</button></footer>
      </form>
    </Modal>
  );
}

/** Why a literal does not fit a port; empty when it does, null while that is not known. */
function useMisfit(port: string, literal: string): string | null {
  const { api } = useEditor();
  const [found, setFound] = useState<{ literal: string; why: string } | null>(null);
  useEffect(() => {
    if (!literal) return undefined;
    let isWanted = true;
    const timer = setTimeout(() => {
      api.post<{ why: string }>('/api/port/check', { port, value: literal }).then(
        ({ why }) => isWanted && setFound({ literal, why }),
        (error: unknown) => isWanted && setFound({ literal, why: sentence(error) }),
      );
    }, PAUSE_MS);
    return () => {
      isWanted = false;
      clearTimeout(timer);
    };
  }, [api, port, literal]);
  return found?.literal === literal ? found.why : null;
}

function FieldInput({ field, text, onChange }: { field: Field; text: string; onChange: (text: string) => void }) {
  const id = useId();
  const shared = { id, value: text, onChange: (event: { target: { value: string } }) => onChange(event.target.value) };
  const choices = field.kind === 'truth' ? ['false', 'true'] : field.choices;
  return (
    <div className="row">
      <label htmlFor={id}>{field.name}</label><span className="type">{field.type}</span>
      {choices.length ? <select {...shared}>{choices.map((one) => <option key={one}>{one}</option>)}</select>
        : <input type="text" inputMode={field.kind === 'number' ? 'decimal' : 'text'} spellCheck={false} {...shared} />}
    </div>
  );
}
