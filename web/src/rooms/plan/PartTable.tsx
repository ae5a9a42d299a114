import { useId } from 'react';

import type { System } from '../../model/system';
import type { Mapping } from './HostTable';
import { placesIn, setName, setsOf, toggled } from './parts';
import type { Profile } from './types';
import type { PlanTexts } from './usePlanTexts';

interface Props { texts: PlanTexts; profile: Profile; system: System; mapping: Mapping; onChange: (mapping: Mapping) => void }

/** Item by item: which components with which of their sets, and which connectors; and where each component goes. */
export function PartTable({ texts, profile, system, mapping, onChange }: Props) {
  const list = useId();
  const { left, place } = mapping;
  const leave = (names: readonly string[], isLeft: boolean) => onChange({ ...mapping, left: toggled(left, names, isLeft) });
  const put = (name: string, value: string) => {
    const rest = Object.fromEntries(Object.entries(place).filter(([one]) => one !== name));
    onChange({ ...mapping, place: value ? { ...rest, [name]: value } : rest });
  };
  const settings = profile.components.flatMap((component) => setsOf(component).map((set) => setName(component.name, set)));
  const wires = profile.connectors.map(({ id }) => id);
  const count = profile.components.length - profile.components.filter(({ name }) => left.has(name)).length;
  return (
    <details className="hosts">
      <summary>{texts.parts} <span className="note">{texts.partsOf(count, profile.components.length)}</span></summary>
      <datalist id={list}>{placesIn(system).map((one) => <option key={one} value={one} />)}</datalist>
      <table>
        <thead><tr><th>{texts.component}</th><th>{texts.from}</th><th>{texts.place2}</th><th>{texts.sets}</th></tr></thead>
        <tbody>
          {profile.components.map((component) => {
            const { name, path } = component;
            const isLeft = left.has(name);
            return (
              <tr key={path}>
                <th scope="row"><label className="check"><input type="checkbox" checked={!isLeft} onChange={() => leave([name], !isLeft)} />{name}</label></th>
                <td><code>{path}</code></td>
                <td><input type="text" list={list} aria-label={`${texts.place2}: ${name}`} disabled={isLeft} value={place[name] ?? ''} onChange={(event) => put(name, event.target.value)} /></td>
                <td><div className="row">{setsOf(component).map((set) => {
                  const one = setName(name, set);
                  return <label key={set} className="check"><input type="checkbox" aria-label={`${texts.sets}: ${one}`} disabled={isLeft} checked={!isLeft && !left.has(one)} onChange={() => leave([one], !left.has(one))} />{set}</label>;
                })}</div></td>
              </tr>
            );
          })}
        </tbody>
      </table>
      {wires.length > 0 && (
        <ul className="wires" aria-label={texts.wires}>
          {profile.connectors.map(({ id, text, ends }) => {
            const isGone = ends.some((end) => left.has(end));
            return <li key={id}><label className="check"><input type="checkbox" disabled={isGone} checked={!isGone && !left.has(id)} onChange={() => leave([id], !left.has(id))} />{text}</label></li>;
          })}
        </ul>
      )}
      <div className="buttons">
        <button type="button" onClick={() => leave(settings, !settings.every((one) => left.has(one)))}>{texts.allSets}</button>
        {wires.length > 0 && <button type="button" onClick={() => leave(wires, !wires.every((one) => left.has(one)))}>{texts.allWires}</button>}
      </div>
    </details>
  );
}
