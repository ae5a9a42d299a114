import { useState } from 'react';

import { Icon } from '../../parts/icons';
import { Section, TextField } from './fields';
import type { VariableRecord } from './types';
import { useMachineTexts } from './useMachine';

interface Props {
  list: readonly VariableRecord[]; values: Readonly<Record<string, string>> | null; canEdit: boolean;
  onChange: (list: readonly VariableRecord[], key: string) => void; onSet: ((name: string, value: string) => void) | null;
}

/** Variables with their first values; of a machine that lives also what they are now, which may be set at once. */
export function VariableTable({ list, values, canEdit, onChange, onSet }: Props) {
  const texts = useMachineTexts();
  const { fields } = texts;
  const put = (index: number, part: Partial<VariableRecord>, key: string) => onChange(list.map((one, place) => (place === index ? { ...one, ...part } : one)), `variables.${index}.${key}`);
  const add = canEdit && <button type="button" className="quiet" onClick={() => onChange([...list, { name: freeName(list), value: '0' }], '')}><Icon name="plus" />{texts.addVariable}</button>;
  return (
    <Section title={fields.variables} action={add}>
      {list.length > 0 && (
        <table className="variables">
          <thead><tr><th scope="col">{fields.variable}</th><th scope="col">{fields.first}</th>{values && <th scope="col">{fields.now}</th>}<td /></tr></thead>
          <tbody>
            {list.map(({ name, value }, index) => (
              <tr key={index}>
                <td><TextField isHidden label={fields.variable} value={name} isDisabled={!canEdit} onChange={(text) => put(index, { name: text }, 'name')} /></td>
                <td><TextField isHidden label={`${fields.first}: ${name}`} value={value} isDisabled={!canEdit} onChange={(text) => put(index, { value: text }, 'value')} /></td>
                {values && <td>{name in values && <Present name={name} value={values[name] ?? ''} onSet={onSet} />}</td>}
                <td>{canEdit && <button type="button" className="quiet" aria-label={texts.removeOf(name)} title={texts.removeOf(name)} onClick={() => onChange(list.filter((_, place) => place !== index), '')}><Icon name="close" /></button>}</td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </Section>
  );
}

/** The present value follows the machine until somebody types. */
function Present({ name, value, onSet }: { name: string; value: string; onSet: Props['onSet'] }) {
  const texts = useMachineTexts();
  const [typed, setTyped] = useState<string | null>(null);
  if (!onSet) return <code>{value}</code>;
  return (
    <form className="present" onSubmit={(event) => {
      event.preventDefault();
      if (typed !== null) onSet(name, typed);
      setTyped(null);
    }}>
      <TextField isHidden label={texts.setOf(name)} value={typed ?? value} onChange={setTyped} />
      {typed !== null && <button type="submit">{texts.set}</button>}
    </form>
  );
}

function freeName(list: readonly VariableRecord[]): string {
  let count = 1;
  while (list.some((one) => one.name === `v${count}`)) count += 1;
  return `v${count}`;
}
