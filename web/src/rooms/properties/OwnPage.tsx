import { useEffect, useId, useState } from 'react';

import { Icon } from '../../parts/icons';
import { sentence } from '../../server/api';
import { useRoomTexts } from '../../texts';
import { propertiesTexts as en } from '../../texts/en/properties';
import { propertiesTexts as ja } from '../../texts/ja/properties';
import { KINDS, hasBounds, isFileName, layoutOf, moved, textOf, type Item, type PageLayout } from './layout';
import { itemTexts, type Source } from './widgets';

interface Props {
  layout: PageLayout; onChange: (layout: PageLayout) => void;
  storages: readonly string[]; targets: readonly string[]; source: Source; canChange: boolean;
  /** Goes to a page that is stored. */
  onLoad: (target: string) => void;
}

/** Puts a page together from properties that are chosen, and saves it through a storage service. */
export function OwnPage({ layout, onChange, storages, targets, source, canChange, onLoad }: Props) {
  const texts = useRoomTexts({ en, ja });
  const id = useId();
  const [target, setTarget] = useState('');
  const change = (items: readonly Item[]) => onChange({ ...layout, items });
  const put = (index: number, changed: Partial<Item>) => change(layout.items.map((item, at) => (at === index ? { ...item, ...changed } : item)));
  const add = () => {
    if (target.trim()) change([...layout.items, { target: target.trim(), kind: '' }]);
    setTarget('');
  };
  return (
    <div className="own-page">
      <label className="field">{texts.title}<input type="text" value={layout.title} onChange={(event) => onChange({ ...layout, title: event.target.value })} /></label>
      {layout.items.length === 0 ? <p className="empty">{texts.noItems}</p> : (
        <ol className="items">
          {layout.items.map((item, index) => (
            // One property may be there twice, as a number and as a plot: only the place tells them apart.
            <li key={`${item.target} ${index}`}>
              <code>{item.target}</code>
              <select aria-label={texts.kindOf(item.target)} value={item.kind} onChange={(event) => put(index, { kind: event.target.value })}>
                {KINDS.map((kind) => <option key={kind} value={kind}>{kind || texts.usual}</option>)}
              </select>
              {hasBounds(item.kind) && (['min', 'max'] as const).map((key) => (
                <input key={key} type="number" step="any" aria-label={texts[key](item.target)} placeholder={key} value={item[key] ?? ''} onChange={(event) => put(index, { [key]: event.target.value })} />
              ))}
              <button type="button" className="quiet" aria-label={texts.up(item.target)} disabled={index === 0} onClick={() => change(moved(layout.items, index, -1))}><Icon name="up" /></button>
              <button type="button" className="quiet" aria-label={texts.down(item.target)} disabled={index === layout.items.length - 1} onClick={() => change(moved(layout.items, index, 1))}><Icon name="down" /></button>
              <button type="button" className="quiet" aria-label={texts.remove(item.target)} onClick={() => change(layout.items.filter((_, at) => at !== index))}><Icon name="close" /></button>
            </li>
          ))}
        </ol>
      )}
      <form className="row" onSubmit={(event) => { event.preventDefault(); add(); }}>
        <input type="text" list={`${id}-targets`} aria-label={texts.target} placeholder={texts.target} value={target} onChange={(event) => setTarget(event.target.value)} />
        <datalist id={`${id}-targets`}>{targets.map((each) => <option key={each} value={each} />)}</datalist>
        <button type="submit">{texts.add}</button>
      </form>
      {storages.length === 0 ? <p className="empty">{texts.noStorage}</p>
        : <Stored layout={layout} storages={storages} source={source} canChange={canChange} onLoad={onLoad} />}
    </div>
  );
}

function Stored({ layout, storages, source, canChange, onLoad }: Omit<Props, 'onChange' | 'targets'>) {
  const texts = useRoomTexts({ en, ja });
  const [chosen, setChosen] = useState('');
  const storage = storages.includes(chosen) ? chosen : storages[0] ?? '';
  const [name, setName] = useState('');
  const [said, setSaid] = useState('');
  const [error, setError] = useState('');
  const [saved, setSaved] = useState<readonly string[]>([]);
  useEffect(() => {
    let isWanted = true;
    source.text(`${storage}.search?name=*.page`).then(
      (text) => isWanted && setSaved(itemTexts(text)),
      (failure: unknown) => isWanted && setError(sentence(failure)),
    );
    return () => {
      isWanted = false;
    };
  }, [source, storage, said]);
  const save = async () => {
    setError(isFileName(name) ? '' : texts.badName(name));
    if (!isFileName(name)) return;
    const target = `${storage}.${name}.page`;
    setSaid('');
    await source.set(target, textOf(layout)).then(() => setSaid(texts.savedAs(target)), (failure: unknown) => setError(sentence(failure)));
  };
  return (
    <>
      <form className="row" onSubmit={(event) => { event.preventDefault(); void save(); }}>
        {storages.length > 1 && (
          <select aria-label={texts.storage} value={storage} onChange={(event) => setChosen(event.target.value)}>
            {storages.map((each) => <option key={each} value={each}>{each}</option>)}
          </select>
        )}
        <input type="text" aria-label={texts.fileName} placeholder={texts.fileName} value={name} onChange={(event) => setName(event.target.value)} />
        <button type="submit" disabled={!canChange || !name || !layout.items.length}>{texts.save}</button>
        <span role="status">{said}</span>
      </form>
      {error && <p className="error" role="alert">{error}</p>}
      {saved.length > 0 && (
        <ul className="row saved" aria-label={texts.saved}>
          {saved.map((each) => <li key={each}><button type="button" onClick={() => onLoad(`${storage}.${each}`)}>{each.replace(/\.page$/, '')}</button></li>)}
        </ul>
      )}
    </>
  );
}

/** Reads a page from where it is stored; throws where it is none, or is not there. */
export const loaded = async (source: Source, target: string): Promise<PageLayout> => layoutOf(await source.text(target));
