import { Fragment, useEffect, useMemo, useRef } from 'react';

import { compared, firstChange, linesOf, near, type DifferenceRow, type Line } from './difference';
import { useBuilderTexts } from './fields';
import { ownLines, tokens } from './highlight';

const SIGNS = { same: ' ', added: '+', removed: '−', changed: '~' } as const;

function Code({ text, file }: { text: string; file: string }) {
  return <code>{tokens(text, file).map((token, index) => (token.kind === 'plain' ? <Fragment key={index}>{token.text}</Fragment> : <span key={index} className={`token-${token.kind}`}>{token.text}</span>))}</code>;
}

/** A file with numbers of lines. Lines that the disk does not have are marked, and those that are the user's. */
export function CodeView({ file, text, before }: { file: string; text: string; before: string | null }) {
  const texts = useBuilderTexts();
  const rows = useMemo(() => compared(before ?? text, text).filter((row) => row.new), [before, text]);
  const own = useMemo(() => ownLines(linesOf(text)), [text]);
  const view = useRef<HTMLDivElement>(null);
  const last = useRef({ file, text });
  // What has just changed by typing is brought into sight.
  useEffect(() => {
    const earlier = last.current;
    last.current = { file, text };
    if (earlier.file !== file || earlier.text === text) return;
    const changed = firstChange(earlier.text, text);
    view.current?.children[changed]?.scrollIntoView({ block: 'nearest' });
  }, [file, text]);
  return (
    // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- What scrolls is reached by keyboard.
    <div ref={view} className="code" role="region" tabIndex={0} aria-label={file}>
      {rows.map((row, index) => (
        <div key={index} className={`line line-${row.kind}${own[index] ? ' is-own' : ''}`} title={own[index] ? texts.preview.own : undefined}>
          <span className="line-number">{row.new?.number}</span><span className="sign" aria-hidden="true">{SIGNS[row.kind]}</span><Code text={row.new?.text ?? ''} file={file} />
        </div>
      ))}
    </div>
  );
}

interface ComparisonProps { file: string; before: string; after: string; left: string; right: string }

/** Two texts side by side, line by line; equal lines far from any change are left out. */
export function Comparison({ file, before, after, left, right }: ComparisonProps) {
  const texts = useBuilderTexts();
  const rows = useMemo(() => near(compared(before, after)), [before, after]);
  return (
    // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex -- What scrolls is reached by keyboard.
    <div className="comparison" role="region" tabIndex={0} aria-label={`${texts.preview.difference}: ${file}`}>
      <table>
        <colgroup><col className="number-column" /><col /><col className="number-column" /><col /></colgroup>
        <thead><tr><th colSpan={2}>{left}</th><th colSpan={2}>{right}</th></tr></thead>
        <tbody>
          {rows.map((row, index) => (typeof row === 'number'
            ? <tr key={index} className="skipped"><td colSpan={4}>{texts.preview.skipped(row)}</td></tr>
            : <tr key={index} className={`line-${row.kind}`}><Side file={file} line={row.old} row={row} gone /><Side file={file} line={row.new} row={row} /></tr>))}
        </tbody>
      </table>
    </div>
  );
}

function Side({ file, line, row, gone = false }: { file: string; line: Line | null; row: DifferenceRow; gone?: boolean }) {
  const texts = useBuilderTexts();
  const kind = row.kind === 'same' || !line ? '' : gone ? 'is-gone' : 'is-new';
  return (
    <>
      <td className={`line-number ${kind}`}>{line?.number}</td>
      <td className={kind}>{kind && <span className="unseen">{gone ? texts.preview.gone : texts.preview.came}: </span>}{line && <><span className="sign" aria-hidden="true">{kind ? (gone ? '−' : '+') : ' '}</span><Code text={line.text} file={file} /></>}</td>
    </>
  );
}
