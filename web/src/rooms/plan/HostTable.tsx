import type { LeftOut } from './parts';
import type { Profile } from './types';
import type { PlanTexts } from './usePlanTexts';

/** How a profile is to be taken: other hosts, places and values, a prefix, and what is left out of it. */
export interface Mapping { map: Record<string, string>; place: Record<string, string>; set: Record<string, string>; prefix: string; left: LeftOut }

export const AS_IT_IS: Mapping = { map: {}, place: {}, set: {}, prefix: '', left: new Set() };

interface Props { texts: PlanTexts; profile: Profile; mapping: Mapping; onChange: (mapping: Mapping) => void }

/** Each host of the profile may stand for another one; values of variables; a prefix. */
export function HostTable({ texts, profile, mapping, onChange }: Props) {
  const hosts = new Set(profile.components.map(({ host }) => host));
  const put = (key: 'map' | 'set', name: string, value: string) => {
    const rest = Object.fromEntries(Object.entries(mapping[key]).filter(([one]) => one !== name));
    onChange({ ...mapping, [key]: value ? { ...rest, [name]: value } : rest });
  };
  return (
    <details className="hosts">
      <summary>{texts.hosts}</summary>
      <table>
        <tbody>
          {[...hosts].map((host) => (
            <tr key={host}>
              <th scope="row">{texts.host}: {host}</th><td />
              <td><input type="text" aria-label={`${texts.to}: ${host}`} placeholder={host} value={mapping.map[host] ?? ''} onChange={(event) => put('map', host, event.target.value)} /></td>
            </tr>
          ))}
          {profile.variables.map(({ name, default: usual, description }) => (
            <tr key={name}>
              <th scope="row">{texts.variables}: {name}</th>
              <td className="note">{description}</td>
              <td><input type="text" aria-label={`${texts.value}: ${name}`} placeholder={usual ?? ''} value={mapping.set[name] ?? ''} onChange={(event) => put('set', name, event.target.value)} /></td>
            </tr>
          ))}
          <tr>
            <th scope="row">{texts.prefix}</th><td />
            <td><input type="text" aria-label={texts.prefix} value={mapping.prefix} onChange={(event) => onChange({ ...mapping, prefix: event.target.value })} /></td>
          </tr>
        </tbody>
      </table>
    </details>
  );
}
