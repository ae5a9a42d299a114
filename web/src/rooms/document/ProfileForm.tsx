import { useState, type SyntheticEvent } from 'react';

import { Fields, Section } from '../../panels/Fields';
import { useEditor } from '../../shell/contexts';
import type { Picture } from './types';
import { useDocumentTexts, type OpenDocument } from './useDocument';

const PARTS = ['vendor', 'name', 'version', 'abstract', 'comment'] as const;
type Typed = Record<(typeof PARTS)[number] | 'log', string>;

/** What the profile tells of itself, with its variables and what it includes. */
export function ProfileForm({ picture, document }: { picture: Picture; document: OpenDocument }) {
  const texts = useDocumentTexts();
  const { canChange, select } = useEditor();
  const { profile } = picture;
  const [typed, setTyped] = useState<Partial<Typed>>({});
  const values: Typed = { ...profile, log: profile.log.join('\n'), ...typed };
  const set = (part: keyof Typed) => (text: string) => setTyped((before) => ({ ...before, [part]: text }));
  const apply = (event: SyntheticEvent) => {
    event.preventDefault();
    const { log, ...rest } = values;
    const { vendor, name, version, abstract, comment } = rest;
    void document.edit({ do: 'identify', vendor, name, version, abstract, comment, log: log ? log.split('\n') : [] }).then((after) => after && setTyped({}));
  };
  return (
    <>
      <h2>{texts.profile}</h2>
      <form className="profile-form" onSubmit={apply}>
        {PARTS.map((part) => <label key={part}>{texts[part]} <input type="text" value={values[part]} disabled={!canChange} onChange={(event) => set(part)(event.target.value)} /></label>)}
        <label>{texts.log} <textarea rows={3} value={values.log} disabled={!canChange} onChange={(event) => set('log')(event.target.value)} /></label>
        {Object.keys(typed).length > 0 && <button type="submit" className="primary" disabled={!canChange}>{texts.apply}</button>}
      </form>
      <Fields rows={[[texts.created, profile.created], [texts.updated, profile.updated]]} />
      {picture.groups.length > 0 && (
        <Section title={texts.groups} count={picture.groups.length}>
          <ul>{picture.groups.map(({ id, members }) => <li key={id}><button type="button" className="link" onClick={() => select(members)}>{id}</button> <span className="note">{members.join(', ')}</span></li>)}</ul>
        </Section>
      )}
      {picture.variables.length + picture.includes.length > 0 && <p className="note">{texts.resolved}</p>}
      {picture.variables.length > 0 && (
        <Section title={texts.variables} count={picture.variables.length}>
          <Fields rows={picture.variables.map((one) => [one.name, <span key={one.name}>{one.value ?? <em className="warning">{texts.noValue}</em>} <span className="note">{one.description}</span></span>] as const)} />
        </Section>
      )}
      {picture.includes.length > 0 && (
        <Section title={texts.includes} count={picture.includes.length}>
          <Fields rows={picture.includes.map((one) => [one.file, `${one.prefix && `${texts.prefix} ${one.prefix} `}${Object.entries(one.values).map(([key, value]) => `${key}=${value}`).join(', ')}` || '–'] as const)} />
        </Section>
      )}
    </>
  );
}
