import { Icon } from '../../parts/icons';
import { ChoiceField, Section, TextField } from './fields';
import type { ActionRecord } from './types';
import { useMachineTexts } from './useMachine';

const NEW: ActionRecord = { kind: 'set', target: '', how: 'value', value: '', every: '' };

interface Props {
  title: string; actions: readonly ActionRecord[]; onChange: (actions: readonly ActionRecord[], key: string) => void; canEdit: boolean; isRepeated?: boolean;
  variables: readonly string[]; problems?: ReadonlyMap<number, string>;
}

/** Actions in their order: what is set, to what, how often. */
export function ActionList({ title, actions, onChange, canEdit, isRepeated = false, variables, problems }: Props) {
  const texts = useMachineTexts();
  const put = (index: number, part: Partial<ActionRecord>, field: string) =>
    onChange(actions.map((one, place) => (place === index ? { ...one, ...part } : one)), `${index}.${field}`);
  const add = canEdit && <button type="button" className="quiet" aria-label={`${title}: ${texts.addAction}`} onClick={() => onChange([...actions, NEW], '')}><Icon name="plus" />{texts.addAction}</button>;
  return (
    <Section title={title} action={add}>
      {actions.length > 0 && (
        <ol className="actions">
          {actions.map((action, index) => (
            <li key={index}>
              <ChoiceField isHidden label={texts.kind} value={action.kind} isDisabled={!canEdit} choices={Object.entries(texts.actionKinds)} onChange={(kind) => put(index, { kind: kind as ActionRecord['kind'] }, 'kind')} />
              {canEdit && <button type="button" className="quiet" aria-label={texts.removeOf(action.target || texts.addAction)} title={texts.removeOf(action.target || texts.addAction)} onClick={() => onChange(actions.filter((_, place) => place !== index), '')}><Icon name="close" /></button>}
              {action.kind === 'assign'
                ? <ChoiceField isHidden label={texts.target} value={action.target} isDisabled={!canEdit} choices={variables.map((one) => [one, one] as const)} onChange={(target) => put(index, { target }, 'target')} />
                : <TextField isHidden label={texts.target} value={action.target} isDisabled={!canEdit} placeholder={action.kind === 'raise' ? texts.event : 'robots/r1.speed'} onChange={(target) => put(index, { target }, 'target')} />}
              {action.kind !== 'raise' && (
                <>
                  <ChoiceField isHidden label={texts.how} value={action.how} isDisabled={!canEdit} choices={Object.entries(texts.hows)} onChange={(how) => put(index, { how: how as ActionRecord['how'] }, 'how')} />
                  <TextField isHidden label={texts.fields.value} value={action.value} isDisabled={!canEdit} onChange={(value) => put(index, { value }, 'value')} />
                </>
              )}
              {isRepeated && <TextField label={texts.every} value={action.every} isDisabled={!canEdit} placeholder="0.2" onChange={(every) => put(index, { every }, 'every')} />}
              {problems?.has(index) && <p className="error">{problems.get(index)}</p>}
            </li>
          ))}
        </ol>
      )}
    </Section>
  );
}
