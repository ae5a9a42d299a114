import { createContext, useContext, useId, type ReactNode } from 'react';

import { Icon } from '../../parts/icons';
import { useRoomTexts } from '../../texts';
import { builderTexts as en, type BuilderTexts } from '../../texts/en/builder';
import { builderTexts as ja } from '../../texts/ja/builder';
import { isForm, propertyAt, textAt, valueAt, withMovedRow, withProperty, withValue, withoutRow, type Finding, type Form } from './form';

/** The form that is edited, its findings, and how it is changed; `about` names the field, so that typing in it is one step. */
export interface Editing { form: Form; findings: readonly Finding[]; types: readonly string[]; change: (form: Form, about?: string) => void }

export const EditingContext = createContext<Editing | null>(null);

export function useEditing(): Editing {
  const editing = useContext(EditingContext);
  if (!editing) throw new Error('useEditing is used outside of a form');
  return editing;
}

export const useBuilderTexts = (): BuilderTexts => useRoomTexts({ en, ja });

type Label = keyof BuilderTexts['fields'];
/** A place ends in the key of its field; keys of extensions have a prefix. */
const labelOf = (place: string): Label => place.slice(place.lastIndexOf('.') + 1).split('::').at(-1) as Label;

interface FieldProps { place: string; label?: Label; list?: string; className?: string | undefined }

/** The frame of a field: its label, and its findings below. */
function Labelled({ label, place, className = '', children }: { label: Label; place: string; className?: string | undefined; children: (id: string, isBad: boolean) => ReactNode }) {
  const texts = useBuilderTexts();
  const id = useId();
  const own = useEditing().findings.filter((one) => one.place === place);
  const isBad = own.some((one) => one.level === 'error');
  return (
    <div className={`field ${className}`}>
      <label htmlFor={id}>{texts.fields[label]}</label>
      {children(id, isBad)}
      {own.length > 0 && <ul id={`${id}-found`}>{own.map((one) => <li key={one.text} className={one.level === 'error' ? 'error' : 'note warning'}>{one.level === 'error' ? '✕' : '⚠'} {one.text}</li>)}</ul>}
    </div>
  );
}

/** One line of text. An empty one is left out of the profile, unless `isKept`. */
export function TextField({ place, label = labelOf(place), list, className, isKept = false }: FieldProps & { isKept?: boolean }) {
  const { form, change } = useEditing();
  const set = (text: string) => change(withValue(form, place, text || isKept ? text : undefined), place);
  return (
    <Labelled label={label} place={place} className={className}>
      {(id, isBad) => <input id={id} type="text" spellCheck={false} list={list} value={textAt(form, place)} aria-invalid={isBad} aria-describedby={`${id}-found`} onChange={(event) => set(event.target.value)} />}
    </Labelled>
  );
}

/** A number; what is none, or is still being typed, stays a text, which the server reads. */
export function NumberField({ place, label = labelOf(place), className }: FieldProps) {
  const { form, change } = useEditing();
  const set = (text: string) => change(withValue(form, place, text.trim() === '' ? undefined : String(Number(text)) === text ? Number(text) : text), place);
  return (
    <Labelled label={label} place={place} className={className}>
      {(id, isBad) => <input id={id} type="text" inputMode="decimal" value={textAt(form, place)} aria-invalid={isBad} aria-describedby={`${id}-found`} onChange={(event) => set(event.target.value)} />}
    </Labelled>
  );
}

export function AreaField({ place, label = labelOf(place), className = '', rows = 2 }: FieldProps & { rows?: number }) {
  const { form, change } = useEditing();
  return (
    <Labelled label={label} place={place} className={`wide ${className}`}>
      {(id, isBad) => <textarea id={id} rows={rows} value={textAt(form, place)} aria-invalid={isBad} onChange={(event) => change(withValue(form, place, event.target.value || undefined), place)} />}
    </Labelled>
  );
}

export function ChoiceField({ place, label = labelOf(place), choices, className }: FieldProps & { choices: readonly string[] }) {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const present = textAt(form, place);
  const all = present && !choices.includes(present) ? [...choices, present] : choices;
  const words: Record<string, string> = texts.words;
  return (
    <Labelled label={label} place={place} className={className}>
      {(id, isBad) => (
        <select id={id} value={present} aria-invalid={isBad} onChange={(event) => change(withValue(form, place, event.target.value), place)}>
          {all.map((one) => <option key={one} value={one}>{words[one] ?? one}</option>)}
        </select>
      )}
    </Labelled>
  );
}

/** Several words in one line, separated by commas. */
export function WordsField({ place, label = labelOf(place) }: FieldProps) {
  const { form, change } = useEditing();
  const value = valueAt(form, place);
  const words = Array.isArray(value) ? value.map(String).join(', ') : '';
  const set = (text: string) => {
    const found = text.split(',').map((one) => one.trimStart());
    change(withValue(form, place, text ? found : undefined), place);
  };
  return <Labelled label={label} place={place}>{(id) => <input id={id} type="text" value={words} onChange={(event) => set(event.target.value)} />}</Labelled>;
}

/** An extension property of a part. */
export function PropertyField({ place, name, label, choices }: { place: string; name: string; label: Label; choices: readonly string[] }) {
  const { form, change } = useEditing();
  const list = useId();
  return (
    <Labelled label={label} place={`${place}.${name}`}>
      {(id) => (
        <>
          <input id={id} type="text" list={list} value={propertyAt(form, place, name)} onChange={(event) => change(withProperty(form, place, name, event.target.value), `${place}.${name}`)} />
          <datalist id={list}>{choices.map((one) => <option key={one} value={one} />)}</datalist>
        </>
      )}
    </Labelled>
  );
}

/** A constraint as text; one that has no text is edited in the source. */
export function ConstraintField({ place }: { place: string }) {
  const texts = useBuilderTexts();
  const { form } = useEditing();
  return isForm(valueAt(form, place)) ? <p className="note">{texts.list.complex}</p> : <TextField place={place} />;
}

/** One part of a list: its name, the buttons that move and remove it, and its fields. */
export function Row({ place, index, count, name, children }: { place: string; index: number; count: number; name: string; children: ReactNode }) {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const title = name || texts.list.unnamed;
  return (
    <fieldset className="part">
      <legend><span>{title}</span></legend>
      <div className="tools">
        <button type="button" className="quiet" aria-label={texts.list.up(title)} title={texts.list.up(title)} disabled={index === 0} onClick={() => change(withMovedRow(form, place, index, -1))}><Icon name="up" /></button>
        <button type="button" className="quiet" aria-label={texts.list.down(title)} title={texts.list.down(title)} disabled={index === count - 1} onClick={() => change(withMovedRow(form, place, index, 1))}><Icon name="down" /></button>
        <button type="button" className="quiet" aria-label={texts.list.remove(title)} title={texts.list.remove(title)} onClick={() => change(withoutRow(form, place, index))}><Icon name="close" /></button>
      </div>
      <div className="fields-grid">{children}</div>
    </fieldset>
  );
}

export function More({ label, children }: { label?: string; children: ReactNode }) {
  const texts = useBuilderTexts();
  return <details className="wide"><summary>{label ?? texts.list.more}</summary><div className="fields-grid">{children}</div></details>;
}
