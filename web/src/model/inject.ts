/** A field of the values that a port takes, as the server has it. */
export interface Field { name: string; kind: 'number' | 'text' | 'truth' | 'choice' | 'json'; type: string; value: unknown; choices: string[] }

/** What is typed for each field, by its name. */
export type Typed = Readonly<Record<string, string>>;

/** The text of a field at the beginning. */
export const firstText = ({ kind, value }: Field): string => (kind === 'json' ? JSON.stringify(value) : String(value));

/** The literal that `rtinject` takes: the data alone where that is all there is, else an object of the fields. */
export function literalOf(fields: readonly Field[], typed: Typed): string {
  const [only] = fields;
  if (fields.length === 1 && only?.name === 'data') return partOf(only, typed);
  const root: Tree = new Map();
  for (const field of fields) {
    const path = field.name.split('.');
    let at = root;
    for (const step of path.slice(0, -1)) {
      const next = at.get(step);
      const below: Tree = typeof next === 'object' ? next : new Map<string, Tree | string>();
      at.set(step, below);
      at = below;
    }
    at.set(path.at(-1) ?? '', partOf(field, typed));
  }
  return textOf(root);
}

// A type cannot name itself before it is there; an interface can.
// eslint-disable-next-line @typescript-eslint/no-empty-object-type
interface Tree extends Map<string, Tree | string> {}

const textOf = (tree: Tree | string): string =>
  (typeof tree === 'string' ? tree : `{${[...tree].map(([name, part]) => `${JSON.stringify(name)}: ${textOf(part)}`).join(', ')}}`);

/** The text of one field as JSON; what is no number is left to the server to refuse. */
function partOf(field: Field, typed: Typed): string {
  const text = typed[field.name] ?? firstText(field);
  return field.kind === 'text' || field.kind === 'choice' ? JSON.stringify(text) : text.trim() || '""';
}
