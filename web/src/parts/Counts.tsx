import type { Count } from '../canvas/graph';
import { useTexts } from '../texts';
import { StateIcon } from './StateIcon';

/** How many components have each look: icon, number and, for readers, the word. */
export function Counts({ counts }: { counts: Count[] }) {
  const texts = useTexts();
  return (
    <ul className="counts">
      {counts.map(([look, count]) => (
        <li key={look} className={`look-${look}`} title={texts.looks[look]}>
          <StateIcon look={look} />
          {count}
          <span className="unseen"> {texts.looks[look]}</span>
        </li>
      ))}
    </ul>
  );
}
