/** A piece of a line, and what it is. */
export interface Token { kind: 'plain' | 'comment' | 'text' | 'word' | 'mark' | 'number'; text: string }

const WORDS = 'and|as|assert|async|await|break|class|continue|def|del|elif|else|except|finally|for|from|if|import|in|is|lambda|None|not|or|pass|raise|return|self|True|False|try|while|with|yield';
const PYTHON = new RegExp(`(?<comment>#.*)|(?<text>"""[^"]*(?:"""|$)|"(?:[^"\\\\]|\\\\.)*"|'(?:[^'\\\\]|\\\\.)*')|(?<mark>@\\w[\\w.]*)|(?<word>\\b(?:${WORDS})\\b)|(?<number>\\b\\d[\\d_.]*\\b)`, 'g');
const XML = /(?<comment><!--.*?(?:-->|$))|(?<text>"[^"]*")|(?<word><\/?[\w:.-]+|\/?>)|(?<mark>[\w:.-]+(?==))/g;
const TOML = /(?<comment>#.*)|(?<text>"(?:[^"\\]|\\.)*")|(?<word>^\[.*\])|(?<mark>^[\w.-]+(?= =))|(?<number>\b\d+\b)/g;
const LANGUAGES: Record<string, RegExp> = { py: PYTHON, xml: XML, toml: TOML };

const KINDS = ['comment', 'text', 'mark', 'word', 'number'] as const;

/** The pieces of a line of a file, by the ending of its name; each line stands for itself. */
export function tokens(line: string, file: string): Token[] {
  const pattern = LANGUAGES[file.slice(file.lastIndexOf('.') + 1)];
  if (!pattern) return [{ kind: 'plain', text: line }];
  const found: Token[] = [];
  let at = 0;
  for (const match of line.matchAll(pattern)) {
    if (match.index > at) found.push({ kind: 'plain', text: line.slice(at, match.index) });
    // Of the named groups one has matched; the others have no text.
    const groups: Record<string, string | undefined> = match.groups ?? {};
    const kind = KINDS.find((one) => groups[one] !== undefined) ?? 'plain';
    found.push({ kind, text: match[0] });
    at = match.index + match[0].length;
  }
  if (at < line.length) found.push({ kind: 'plain', text: line.slice(at) });
  return found;
}

/** Whether each line stands between marks of user code: it is kept when the file is generated again. */
export function ownLines(lines: readonly string[]): boolean[] {
  let isOwn = false;
  return lines.map((line) => {
    if (/^\s*# <user code [^>]*>\s*$/.test(line)) {
      isOwn = true;
      return false;
    }
    if (/^\s*# <\/user code [^>]*>\s*$/.test(line)) isOwn = false;
    return isOwn;
  });
}
