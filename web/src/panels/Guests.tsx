import { shortName } from '../model/ports';
import type { System } from '../model/system';
import type { Component, Context } from '../model/types';
import { Icon } from '../parts/icons';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { Link } from './Link';

/** Components that a context drives besides its owner: attached and detached here, but for members of a composite. */
export function Guests({ system, component, context }: { system: System; component: Component; context: Context }) {
  const { contexts: words, label } = useTexts().manage;
  const { canMake, perform } = useEditor();
  const share = (verb: 'attach' | 'detach', id: string) =>
    void perform([{ do: verb, component: component.id, context: context.id, participant: id }], label[verb](shortName(id), component.name));
  const others = [...system.components.values()].filter((one) => one.process === component.process && one.id !== component.id && !context.participants.includes(one.id));
  return (
    <>
      {context.participants.map((id) => (
        <p key={id} className="row">{words.drives} <Link id={id} />
          {!component.is_composite && <button type="button" className="quiet" disabled={!canMake} aria-label={words.detach(shortName(id))} title={words.detach(shortName(id))} onClick={() => share('detach', id)}><Icon name="close" /></button>}
        </p>
      ))}
      {!component.is_composite && others.length > 0 && (
        <select aria-label={words.choose} value="" disabled={!canMake} onChange={(event) => event.target.value && share('attach', event.target.value)}>
          <option value="">{words.choose} …</option>
          {others.map((one) => <option key={one.id} value={one.id}>{one.name}</option>)}
        </select>
      )}
    </>
  );
}
