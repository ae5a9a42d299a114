import { useId, useState, type HTMLInputTypeAttribute, type ReactNode } from 'react';

interface TextProps {
  label: string; value: string; onChange: (value: string) => void; isDisabled?: boolean; placeholder?: string; list?: string; isHidden?: boolean; isBad?: boolean;
  type?: HTMLInputTypeAttribute;
}

/** A line of text with its label; the label is for readers only where the place says it. */
export function TextField({ label, value, onChange, isDisabled = false, placeholder = '', list, isHidden = false, isBad = false, type = 'text' }: TextProps) {
  const input = (
    <input type={type} value={value} disabled={isDisabled} placeholder={placeholder} list={list} aria-invalid={isBad || undefined} spellCheck={false}
      aria-label={isHidden ? label : undefined} onChange={(event) => onChange(event.target.value)} />
  );
  return isHidden ? input : <label className="field"><span>{label}</span>{input}</label>;
}

interface ChoiceProps { label: string; value: string; choices: readonly (readonly [value: string, text: string])[]; onChange: (value: string) => void; isDisabled?: boolean; isHidden?: boolean }

export function ChoiceField({ label, value, choices, onChange, isDisabled = false, isHidden = false }: ChoiceProps) {
  const select = (
    <select value={value} disabled={isDisabled} aria-label={isHidden ? label : undefined} onChange={(event) => onChange(event.target.value)}>
      {!choices.some(([one]) => one === value) && <option value={value}>{value || '–'}</option>}
      {choices.map(([one, text]) => <option key={one} value={one}>{text}</option>)}
    </select>
  );
  return isHidden ? select : <label className="field"><span>{label}</span>{select}</label>;
}

interface NameProps { label: string; name: string; fault: (name: string) => string; onName: (name: string) => void; isDisabled: boolean }

/** A name takes effect with Enter or when the field is left, if it can be one: half of a name is none. */
export function NameField({ label, name, fault, onName, isDisabled }: NameProps) {
  const [typed, setTyped] = useState<string | null>(null);
  const id = useId();
  const text = typed ?? name;
  const why = typed === null || typed === name ? '' : fault(typed);
  const take = () => {
    if (typed !== null && typed !== name && !why) onName(typed);
    if (!why) setTyped(null);
  };
  return (
    <>
      <label className="field">
        <span>{label}</span>
        <input type="text" className="machine-name" value={text} disabled={isDisabled} aria-invalid={why !== '' || undefined} aria-describedby={why ? id : undefined} spellCheck={false}
          onChange={(event) => setTyped(event.target.value)} onBlur={take}
          onKeyDown={(event) => {
            if (event.key === 'Enter') take();
            if (event.key === 'Escape') setTyped(null);
          }} />
      </label>
      {why && <p className="error" id={id}>{why}</p>}
    </>
  );
}

export function Section({ title, children, action }: { title: string; children: ReactNode; action?: ReactNode }) {
  return <section className="part"><header><h3>{title}</h3>{action}</header>{children}</section>;
}
