import type { Profile } from './types';
import type { PlanTexts } from './usePlanTexts';

export interface Mapping { map: Record<string, string>; set: Record<string, string>; prefix: string }

interface Props { texts: PlanTexts; profile: Profile; mapping: Mapping; onChange: (mapping: Mapping) => void }

/** Where components go: each host of the profile may stand for another one; values of variables; a prefix. */
export function HostTable({ texts, profile, mapping, onChange }: Props) {
  const hosts = new Map<string, string>();
  for (const { name, host } of profile.components) if (!hosts.has(host)) hosts.set(host, name);
  const put = (key: 'map' | 'set', name: string, value: string) => {
    const rest = Object.fromEntries(Object.entries(mapping[key]).filter(([one]) => one !== name));
    onChange({ ...mapping, [key]: value ? { ...rest, [name]: value } : rest });
  };
  return (
    <details className="hosts">
      <summary>{texts.hosts}</summary>
      <table>
        <thead><tr><th>{texts.component}</th><th>{texts.from}</th><th>{texts.to}</th></tr></thead>
        <tbody>
          {profile.components.map(({ name, path, host }) => (
            <tr key={path}>
              <th scope="row">{name}</th>
              <td><code>{path}</code></td>
              <td>{hosts.get(host) === name
                ? <input type="text" aria-label={`${texts.to}: ${host}`} placeholder={host} value={mapping.map[host] ?? ''} onChange={(event) => put('map', host, event.target.value)} />
                : <span className="note">{mapping.map[host] || host}</span>}</td>
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
