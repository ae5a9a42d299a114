import { useId } from 'react';

import { misfit, splitList, widgetFor, type Misfit, type Widget } from '../model/parameters';
import { Icon } from '../parts/icons';
import { useTexts, type Texts } from '../texts';

interface Props {
  name: string; live: string; typed: string | null; widget: string; constraint: string; isDisabled: boolean;
  onChange: (text: string) => void;
}

/** One parameter with the widget that its author chose; changed values are marked, bad ones say why. */
export function ParameterField({ name, live, typed, widget, constraint, isDisabled, onChange }: Props) {
  const texts = useTexts();
  const id = useId();
  const value = typed ?? live;
  const isChanged = typed !== null && typed !== live;
  const shape = widgetFor(widget, constraint);
  const why = isChanged ? misfitText(misfit(value, constraint, widget), texts) : '';
  const isGroup = shape.kind === 'radio' || shape.kind === 'checkbox' || shape.kind === 'ordered_list';
  const control = <Control id={id} name={name} shape={shape} value={value} isBad={why !== ''} isDisabled={isDisabled} onChange={onChange} />;
  const title = <>{name}{isChanged && <em className="mark">{texts.inspector.changed}</em>}{constraint && <span className="rule">{constraint}</span>}</>;
  const notes = <p id={`${id}-why`} className="error">{why}</p>;
  const className = `parameter ${isChanged ? 'is-changed' : ''} ${why ? 'is-bad' : ''}`;
  if (isGroup) return <fieldset className={className} disabled={isDisabled}><legend>{title}</legend>{control}{why && notes}</fieldset>;
  return <div className={className}><label htmlFor={id}>{title}</label>{control}{why && notes}</div>;
}

function misfitText(why: Misfit, texts: Texts): string {
  if (!why) return '';
  if (why.kind === 'not-a-number') return texts.misfit.notANumber;
  return why.kind === 'must-satisfy' ? texts.misfit.mustSatisfy(why.rule) : texts.misfit.notOffered(why.value);
}

interface ControlProps { id: string; name: string; shape: Widget; value: string; isBad: boolean; isDisabled: boolean; onChange: (text: string) => void }

function Control({ id, name, shape, value, isBad, isDisabled, onChange }: ControlProps) {
  const shared = { id, value, disabled: isDisabled, 'aria-invalid': isBad, 'aria-describedby': isBad ? `${id}-why` : undefined };
  const onInput = (event: { target: { value: string } }) => onChange(event.target.value);
  if (shape.kind === 'slider')
    return (
      <span className="slider">
        <input {...shared} type="range" min={shape.low} max={shape.high} step={shape.step} onChange={onInput} />
        <input type="text" inputMode="decimal" aria-label={name} value={value} disabled={isDisabled} aria-invalid={isBad} onChange={onInput} />
      </span>
    );
  if (shape.kind === 'spin')
    return <input {...shared} type="number" min={shape.low ?? undefined} max={shape.high ?? undefined} step="any" onChange={onInput} />;
  if (shape.kind === 'text') return <input {...shared} type="text" onChange={onInput} />;
  if (shape.kind === 'radio')
    return (
      <span className="choices">
        {shape.choices.map((choice) => <label key={choice}><input type="radio" name={id} checked={value === choice} onChange={() => onChange(choice)} />{choice}</label>)}
      </span>
    );
  if (shape.kind === 'checkbox') return <Checks choices={shape.choices} value={value} onChange={onChange} />;
  return <OrderedList choices={shape.choices} value={value} onChange={onChange} />;
}

interface ListProps { choices: string[]; value: string; onChange: (text: string) => void }

function Checks({ choices, value, onChange }: ListProps) {
  const chosen = splitList(value);
  const toggle = (choice: string, isOn: boolean) =>
    onChange(choices.filter((one) => (one === choice ? isOn : chosen.includes(one))).join(','));
  return (
    <span className="choices">
      {choices.map((choice) => <label key={choice}><input type="checkbox" checked={chosen.includes(choice)} onChange={(event) => toggle(choice, event.target.checked)} />{choice}</label>)}
    </span>
  );
}

/** Chosen elements in their order, each may be moved or left out; those not chosen can be added at the end. */
function OrderedList({ choices, value, onChange }: ListProps) {
  const texts = useTexts();
  const chosen = splitList(value);
  const swap = (index: number, by: number) => {
    const after = [...chosen];
    const [moved] = after.splice(index, 1);
    if (moved !== undefined) after.splice(index + by, 0, moved);
    onChange(after.join(','));
  };
  const rest = choices.filter((choice) => !chosen.includes(choice));
  return (
    <ol className="ordered">
      {chosen.map((item, index) => (
        <li key={`${item} ${index}`}>
          <label><input type="checkbox" checked onChange={() => onChange(chosen.filter((_, at) => at !== index).join(','))} />{item}</label>
          <button type="button" className="quiet" disabled={index === 0} aria-label={texts.list.up(item)} title={texts.list.up(item)} onClick={() => swap(index, -1)}><Icon name="up" /></button>
          <button type="button" className="quiet" disabled={index === chosen.length - 1} aria-label={texts.list.down(item)} title={texts.list.down(item)} onClick={() => swap(index, 1)}><Icon name="down" /></button>
        </li>
      ))}
      {rest.map((item) => <li key={item} className="is-off"><label><input type="checkbox" checked={false} onChange={() => onChange([...chosen, item].join(','))} />{item}</label></li>)}
    </ol>
  );
}
