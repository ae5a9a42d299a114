import { isWhole, type Scope } from '../model/scope';
import { shortName } from '../model/ports';
import type { System } from '../model/system';
import { useEditor } from '../shell/contexts';
import { KIND_FILTERS, type Filter } from '../shell/view';
import { useTexts } from '../texts';

type Records = Pick<System, 'managers' | 'components'>;

/** Filters by kind, host, manager and type. All but the kind hold for the diagram, too. */
export function MoreFilters({ managers, components, filter, scope }: Records & { filter: Filter; scope: Scope }) {
  const words = useTexts().manage.scope;
  const { filter: setFilter, narrow } = useEditor();
  const hosts = [...new Set([...managers.values()].map((one) => one.host))].sort();
  const types = [...new Set([...components.values()].map((one) => one.type))].sort();
  const choose = (part: 'host' | 'manager' | 'type') => (value: string) => narrow({ ...scope, [part]: value });
  return (
    <details className="more" open={filter.kind !== 'all' || !isWhole(scope)}>
      <summary>{words.more}</summary>
      <Choice label={words.kind} value={filter.kind} options={KIND_FILTERS.map((kind) => [kind, words.kinds[kind]])} onChange={(kind) => setFilter({ ...filter, kind: kind as Filter['kind'] })} />
      {hosts.length > 1 && <Choice label={words.host} value={scope.host} options={[['', words.allHosts], ...hosts.map((one): [string, string] => [one, one])]} onChange={choose('host')} />}
      {managers.size > 1 && <Choice label={words.manager} value={scope.manager} options={[['', words.allManagers], ...[...managers.keys()].map((one): [string, string] => [one, shortName(one)])]} onChange={choose('manager')} />}
      <Choice label={words.type} value={scope.type} options={[['', words.allTypes], ...types.map((one): [string, string] => [one, one])]} onChange={choose('type')} />
    </details>
  );
}

function Choice({ label, value, options, onChange }: { label: string; value: string; options: [string, string][]; onChange: (value: string) => void }) {
  return (
    <select aria-label={label} title={label} value={value} onChange={(event) => onChange(event.target.value)}>
      {options.map(([key, text]) => <option key={key} value={key}>{text}</option>)}
    </select>
  );
}
