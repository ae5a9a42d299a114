import { useState, type SyntheticEvent } from 'react';

import { Icon } from '../../parts/icons';
import { useDocumentTexts } from './useDocument';

interface Props {
  values: Record<string, string>; isFixed: boolean;
  /** Called with null for a property that is to go. */
  onChange: (key: string, value: string | null) => void;
}

/** Names and values that can be changed, added and removed; a value is taken when the field is left or by Enter. */
export function PropertyTable({ values, isFixed, onChange }: Props) {
  const texts = useDocumentTexts();
  const [key, setKey] = useState('');
  const [value, setValue] = useState('');
  const add = (event: SyntheticEvent) => {
    event.preventDefault();
    onChange(key.trim(), value);
    setKey('');
    setValue('');
  };
  return (
    <div className="property-table">
      {Object.entries(values).map(([name, text]) => (
        <div key={`${name} ${text}`} className="row">
          <label className="grow"><code>{name}</code> <input type="text" defaultValue={text} disabled={isFixed}
            onKeyDown={(event) => event.key === 'Enter' && event.currentTarget.blur()} onBlur={(event) => event.target.value !== text && onChange(name, event.target.value)} /></label>
          <button type="button" className="quiet" disabled={isFixed} aria-label={texts.removeProperty(name)} title={texts.removeProperty(name)} onClick={() => onChange(name, null)}><Icon name="close" /></button>
        </div>
      ))}
      <form className="row" onSubmit={add}>
        <input type="text" aria-label={texts.name} placeholder={texts.name} value={key} disabled={isFixed} onChange={(event) => setKey(event.target.value)} />
        <input type="text" aria-label={texts.value} placeholder={texts.value} value={value} disabled={isFixed} onChange={(event) => setValue(event.target.value)} />
        <button type="submit" disabled={isFixed || !key.trim()}>{texts.addProperty}</button>
      </form>
    </div>
  );
}
