import { shortName } from '../model/ports';
import { WHOLE } from '../model/scope';
import type { System } from '../model/system';
import type { Component } from '../model/types';
import { Icon } from '../parts/icons';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { Link } from './Link';

/** What is in a composite: members, which of their ports it shows, and the way into it. */
export function CompositeParts({ system, component }: { system: System; component: Component }) {
  const { composites: words, label } = useTexts().manage;
  const { canMake, perform, narrow } = useEditor();
  const members = component.members.flatMap((id) => system.components.get(id) ?? []);
  const others = [...system.components.values()].filter((one) => one.process === component.process && one.id !== component.id && !one.composite);
  const shows = new Set(component.ports.map((port) => port.name));
  const change = (isAdded: boolean, member: Component, ports: string[]) => {
    const name = ports[0] ? `${member.name}:${ports[0]}` : member.name;
    const told = ports.length ? (isAdded ? label.show : label.hide) : isAdded ? label.takeIn : label.letGo;
    void perform([{ do: isAdded ? 'add_member' : 'remove_member', component: component.id, member: member.id, ports }], told(name, component.name));
  };
  return (
    <div className="composite-parts">
      {members.length === 0 && <p className="empty">{words.none}</p>}
      <ul>
        {members.map((member) => (
          <li key={member.id}>
            <p className="row"><Link id={member.id} />
              <button type="button" className="quiet" disabled={!canMake} aria-label={words.letGo(member.name)} title={words.letGo(member.name)} onClick={() => change(false, member, [])}><Icon name="close" /></button>
            </p>
            {member.ports.map(({ name }) => {
              const isShown = shows.has(`${member.name}.${name}`);
              return (
                <label key={name} className="check">
                  <input type="checkbox" checked={isShown} disabled={!canMake} onChange={() => change(!isShown, member, [name])} />{words.shown(name)}
                </label>
              );
            })}
          </li>
        ))}
      </ul>
      {others.length > 0 && (
        <select aria-label={words.takeIn} value="" disabled={!canMake} onChange={(event) => {
          const chosen = system.components.get(event.target.value);
          if (chosen) change(true, chosen, []);
        }}>
          <option value="">{words.takeIn} …</option>
          {others.map((one) => <option key={one.id} value={one.id}>{shortName(one.id)}</option>)}
        </select>
      )}
      <div className="buttons">
        <button type="button" disabled={!members.length} onClick={() => narrow({ ...WHOLE, inside: component.id })}>{words.inside}</button>
        <button type="button" disabled={!canMake} onClick={() => void perform([{ do: 'dissolve', component: component.id }], label.dissolve(component.name))}>{words.dissolve}</button>
      </div>
    </div>
  );
}
