import { StateIcon } from '../../parts/StateIcon';
import type { Look } from '../../model/types';
import { useEditor } from '../../shell/contexts';
import { countsOf } from './picture';
import type { Picture, Severity } from './types';
import { useDocumentTexts } from './useDocument';

const LOOKS: Record<Severity, Look> = { error: 'error', warning: 'stuck', note: 'created' };
const ORDER: readonly Severity[] = ['error', 'warning', 'note'];

/** What the static checks find, as `rtprofile check` tells it; each leads to what it is about. */
export function FindingList({ picture }: { picture: Picture }) {
  const texts = useDocumentTexts();
  const { reveal, select } = useEditor();
  const counts = countsOf(picture.findings);
  const boxes = new Set(picture.components.map((one) => one.id));
  const sorted = ORDER.flatMap((severity) => picture.findings.filter((one) => one.severity === severity));
  return (
    <section className="document-findings" aria-label={texts.findings}>
      <h3>{texts.findings} <span className="note">{sorted.length ? texts.counts(counts.error, counts.warning, counts.note) : texts.clean}</span></h3>
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- what scrolls must be reached by keys */}
      <ul tabIndex={0} aria-label={texts.findings}>
        {sorted.map((one, index) => (
          <li key={index} className={`look-${LOOKS[one.severity]}`}>
            <StateIcon look={LOOKS[one.severity]} /><span className="severity">{texts.severity[one.severity]}</span>
            {one.on ? <button type="button" className="link" onClick={() => (boxes.has(one.on) ? reveal(one.on) : select([one.on]))}>{one.text}</button> : <span>{one.text}</span>}
            <code>{one.rule}</code>
          </li>
        ))}
      </ul>
    </section>
  );
}
