import type { Finding } from './types';
import { useDocumentTexts } from './useDocument';

/** The findings about one thing, in full. */
export function FindingTexts({ findings }: { findings: readonly Finding[] }) {
  const texts = useDocumentTexts();
  if (!findings.length) return null;
  return (
    <ul className="finding-texts">
      {findings.map((one, index) => <li key={index} className={`is-${one.severity}`}><strong>{texts.severity[one.severity]}</strong> {one.text}{one.allowed && <span className="note"> ({one.allowed})</span>}</li>)}
    </ul>
  );
}
