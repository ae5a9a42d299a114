import { FIELDS, newGroup, newTerm, noFilter, replaced, type Field, type Group, type LogFilter, type Part, type Term } from '../../model/logFilter';
import { Icon } from '../../parts/icons';
import { useLogTexts } from './useLogTexts';

interface Props { filter: LogFilter; problem: string; onChange: (filter: LogFilter) => void }

/** The filter of the log: a tree of conditions, and a range of time. */
export function FilterEditor({ filter, problem, onChange }: Props) {
  const texts = useLogTexts();
  const put = (id: number, part: Part | null) => onChange({ ...filter, root: replaced({ ...filter.root }, id, part) });
  const { root, from, to } = filter;
  return (
    <fieldset className="log-filter">
      <legend>{texts.filter}</legend>
      <GroupEditor group={root} onPut={(part) => part?.kind === 'group' && onChange({ ...filter, root: part })} onPutBelow={put} />
      <div className="range">
        <label>{texts.from}<input type="datetime-local" step="1" value={from} onChange={(event) => onChange({ ...filter, from: event.target.value })} /></label>
        <label>{texts.to}<input type="datetime-local" step="1" value={to} onChange={(event) => onChange({ ...filter, to: event.target.value })} /></label>
        <button type="button" onClick={() => onChange(noFilter())}>{texts.reset}</button>
      </div>
      {problem && <p className="bad" role="alert">{texts.badPattern(problem)}</p>}
    </fieldset>
  );
}

interface GroupProps { group: Group; onPut: (part: Part | null) => void; onPutBelow: (id: number, part: Part | null) => void; isInner?: boolean }

function GroupEditor({ group, onPut, onPutBelow, isInner = false }: GroupProps) {
  const texts = useLogTexts();
  const add = (part: Part) => onPut({ ...group, parts: [...group.parts, part] });
  return (
    <div className="log-group" role="group" aria-label={texts[group.join]}>
      <div className="row">
        <select aria-label={texts.filter} value={group.join} onChange={(event) => onPut({ ...group, join: event.target.value as Group['join'] })}>
          <option value="and">{texts.and}</option>
          <option value="or">{texts.or}</option>
        </select>
        <button type="button" className="quiet" onClick={() => add(newTerm())}><Icon name="plus" />{texts.addTerm}</button>
        <button type="button" className="quiet" onClick={() => add(newGroup(group.join === 'and' ? 'or' : 'and'))}><Icon name="plus" />{texts.addGroup}</button>
        {isInner && <button type="button" className="quiet" aria-label={texts.removeGroup} title={texts.removeGroup} onClick={() => onPut(null)}><Icon name="close" /></button>}
      </div>
      {group.parts.map((part) => (part.kind === 'group'
        ? <GroupEditor key={part.id} group={part} isInner onPut={(next) => onPutBelow(part.id, next)} onPutBelow={onPutBelow} />
        : <TermEditor key={part.id} term={part} onPut={(next) => onPutBelow(part.id, next)} />))}
    </div>
  );
}

function TermEditor({ term, onPut }: { term: Term; onPut: (term: Term | null) => void }) {
  const texts = useLogTexts();
  return (
    <div className="row">
      <select aria-label={texts.field} value={term.field} onChange={(event) => onPut({ ...term, field: event.target.value as Field })}>
        {FIELDS.map((field) => <option key={field} value={field}>{texts.fields[field]}</option>)}
      </select>
      <label className="check"><input type="checkbox" checked={term.isNot} onChange={(event) => onPut({ ...term, isNot: event.target.checked })} />{texts.not}</label>
      <select aria-label={texts.how} value={term.isPattern ? 'matches' : 'has'} onChange={(event) => onPut({ ...term, isPattern: event.target.value === 'matches' })}>
        <option value="has">{texts.has}</option>
        <option value="matches">{texts.matches}</option>
      </select>
      <input type="text" aria-label={texts.text} spellCheck={false} value={term.text} onChange={(event) => onPut({ ...term, text: event.target.value })} />
      <button type="button" className="quiet" aria-label={texts.remove} title={texts.remove} onClick={() => onPut(null)}><Icon name="close" /></button>
    </div>
  );
}
