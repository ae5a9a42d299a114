import { useEffect, useMemo, useState } from 'react';

import { lackingAt, managersAt } from '../../model/rights';
import type { System } from '../../model/system';
import { RightsNote } from '../../panels/RightsGate';
import { Icon } from '../../parts/icons';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { RoomProps } from '../../shell/rooms';
import { useRoomTexts, useTexts } from '../../texts';
import { propertiesTexts as en } from '../../texts/en/properties';
import { propertiesTexts as ja } from '../../texts/ja/properties';
import { OwnPage, loaded } from './OwnPage';
import { PropertyPanel } from './PropertyPanel';
import { PropertyTree } from './PropertyTree';
import { NO_LAYOUT, layoutOf, textOf, type PageLayout } from './layout';
import './properties.css';
import { createSource, type SetDone } from './source';
import { ownersOf, targetOf } from './tree';
import { useNames, usePropertyPage, useServices, type Wanted } from './useProperties';

/** So begins what the address names when it is a page that was put together; behind it is where that is stored. */
const OWN = 'page:';
const KEY = 'rtkit.page';

/** Live properties: a tree of them, the page of each, and pages put together from several. */
export default function PropertyRoom({ system, view }: RoomProps) {
  const texts = useRoomTexts({ en, ja });
  const { label: labels, plan } = useTexts();
  const { api, canChange, show, remember, values: { page: id } } = useEditor();
  const [done, setDone] = useState<SetDone | null>(null);
  const [layout, setLayout] = useState(kept);
  // Whoever comes from the diagram sees what is selected there.
  const of = view.of || (view.selection.find((id) => system.components.has(id) || system.managers.has(id)) ?? '');
  const isOwn = of.startsWith(OWN);
  const lacking = lackingOf(system, isOwn ? layout.items.map(({ target }) => target) : [of]);
  const isFixed = system.isReadOnly || lacking !== '';
  const source = useMemo(() => createSource(api, id, isFixed, (news) => {
    setDone(news);
    if (news.undo) remember({ label: labels.set(news.target), actions: news.undo, change: news.change });
  }), [api, id, isFixed, remember, labels]);
  const services = useServices(api, system.structure);
  const owners = useMemo(() => ownersOf(services, system), [services, system]);
  const { names, load } = useNames(api);
  const [loading, setLoading] = useState('');
  const stored = isOwn ? of.slice(OWN.length) : '';
  const isUp = canChange || (system.isReadOnly && system.isKnown);

  const change = (next: PageLayout) => {
    sessionStorage.setItem(KEY, textOf(next));
    setLayout(next);
  };
  useEffect(() => {
    if (!stored) return undefined;
    let isWanted = true;
    loaded(source, stored).then((next) => {
      if (!isWanted) return;
      setLayout(next);
      setLoading('');
    }, (error: unknown) => isWanted && setLoading(sentence(error)));
    return () => {
      isWanted = false;
    };
  }, [source, stored]);

  const wanted: Wanted | null = isOwn ? (layout.items.length ? { layout: textOf({ ...layout, title: '' }) } : null) : of ? { of } : null;
  const page = usePropertyPage(isUp, wanted);
  const targets = useMemo(() => owners.flatMap(({ target }) => [target, ...(names.get(target) ?? []).map((name) => targetOf(target, name))]), [owners, names]);
  const storages = services.filter(({ types }) => types.includes('storage')).map(({ target }) => target);
  const add = () => {
    change({ ...layout, items: [...layout.items, { target: of, kind: '' }] });
    show('properties', OWN);
  };
  const title = isOwn ? layout.title || texts.ownPage : of || texts.heading;
  const problem = loading || page.error || (page.why && texts.silent(page.why));

  return (
    <main className="room properties" aria-labelledby="properties-title">
      <PropertyTree owners={owners} names={names} load={load} selected={isOwn ? '' : of} onSelect={(target) => show('properties', target)} />
      <div className="property-page">
        <header>
          <h2 id="properties-title">{title}</h2>
          {!isOwn && of && <button type="button" onClick={add}><Icon name="plus" />{texts.addToOwn}</button>}
          <button type="button" aria-pressed={isOwn} onClick={() => show('properties', OWN)}>{texts.ownPage}</button>
        </header>
        {isOwn && (
          <details className="section" open={!stored}>
            <summary><h3>{texts.edit}</h3></summary>
            <OwnPage layout={layout} onChange={change} storages={storages} targets={targets} source={source} canChange={canChange} onLoad={(target) => show('properties', OWN + target)} />
          </details>
        )}
        {problem && <p className="error" role="alert">{problem}</p>}
        {lacking && <RightsNote system={system} ids={[lacking]} />}
        {!wanted && !isOwn && <p className="empty">{texts.choose}</p>}
        {wanted && page.gui && <PropertyPanel key={`${of} ${texts.heading}`} gui={page.gui} source={source} values={page.values} isLost={!isUp} />}
        {wanted && !page.gui && !problem && <p className="empty">{texts.asking}</p>}
      </div>
      <div className="last-command" role="status">
        {done && <><span>{texts.lastSet}</span><code>{done.command}</code><CopyButton text={done.command} label={texts.copy} /></>}
        {done?.undo === null && <span className="note">{plan.noUndo(done.undo_reason)}</span>}
      </div>
    </main>
  );
}

function CopyButton({ text, label }: { text: string; label: string }) {
  return <button type="button" className="quiet" aria-label={label} title={label} onClick={() => void navigator.clipboard.writeText(text)}><Icon name="copy" /></button>;
}

/** The manager at which properties may not be set; empty if some may be. */
function lackingOf(system: System, targets: readonly string[]): string {
  const found = targets.map((target) => lackingAt(system, managersAt(system, target), 'operator')?.id ?? '');
  return found.includes('') ? '' : (found[0] ?? '');
}

/** The page that was being put together in this tab. */
function kept(): PageLayout {
  const text = sessionStorage.getItem(KEY);
  try {
    return text ? layoutOf(text) : NO_LAYOUT;
  } catch {
    return NO_LAYOUT;
  }
}
