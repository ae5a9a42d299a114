import type { System } from '../model/system';
import type { Component } from '../model/types';
import { WHOLE } from '../model/scope';
import { StateIcon } from '../parts/StateIcon';
import { Icon } from '../parts/icons';
import { age, clock } from '../parts/numbers';
import { useNow } from '../parts/useNow';
import { useEditor } from '../shell/contexts';
import type { View } from '../shell/view';
import { useTexts } from '../texts';
import { CompositeParts } from './CompositeParts';
import { Configuration } from './Configuration';
import { Contexts } from './Contexts';
import { Fields, Section } from './Fields';
import { Link } from './Link';
import { PortList } from './PortList';
import { VerbButtons } from './VerbButtons';

interface Props { system: System; component: Component; drafts: View['drafts'] }

export function ComponentInspector({ system, component, drafts }: Props) {
  const texts = useTexts();
  const { canChange, canMake, open, narrow } = useEditor();
  const words = texts.inspector;
  const properties = Object.entries(component.properties);
  return (
    <>
      <div className={`headline look-${component.look}`}>
        <StateIcon look={component.look} />
        <h2>{component.name}</h2>
        <p><strong>{component.word}</strong> <Since since={component.since} /></p>
      </div>
      {component.remark && <p className="remark">{component.remark}</p>}
      <VerbButtons components={[component]} />
      <div className="buttons">
        <button type="button" onClick={() => narrow({ ...WHOLE, near: component.id })}>{texts.manage.scope.near}</button>
        {!component.is_composite && component.look !== 'zombie' && <button type="button" disabled={!canMake} onClick={() => open({ kind: 'compose', members: [component.id] })}>{texts.manage.composites.make}</button>}
      </div>
      <Fields rows={[
        [words.type, <span key="type" title={component.type_id}>{component.type}</span>],
        [words.process, <Link key="process" id={component.process} />],
        [words.composite, component.composite && <Link key="composite" id={component.composite} />],
        [words.description, component.description],
        [words.path, <code key="path">{component.id}</code>],
      ]} />
      {component.is_composite && <Section title={texts.manage.composites.members} count={component.members.length}><CompositeParts system={system} component={component} /></Section>}
      <Section title={words.contexts} count={component.contexts.length}><Contexts system={system} component={component} /></Section>
      <Section title={words.ports} count={component.ports.length}>
        <PortList system={system} component={component} />
        {component.ports.length > 0 && (
          <button type="button" disabled={!canChange} onClick={() => open({ kind: 'connect', from: null, to: null, component: component.id })}>
            <Icon name="plus" />{words.connect}<kbd>C</kbd>
          </button>
        )}
      </Section>
      <Section title={words.configuration}><Configuration component={component} drafts={drafts} /></Section>
      <Section title={words.properties} count={properties.length} isOpen={false}>
        {properties.length ? <Fields rows={properties} /> : <p className="empty">{words.noProperties}</p>}
      </Section>
    </>
  );
}

function Since({ since }: { since: number }) {
  const texts = useTexts();
  const now = useNow();
  if (!since) return null;
  return <span className="since" title={new Date(since * 1000).toLocaleString()}>{texts.inspector.since} {clock(since)} ({age(since, now)})</span>;
}
