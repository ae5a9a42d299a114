import { shortName } from '../model/ports';
import { useEditor } from '../shell/contexts';

/** A name that leads to what it names. */
export function Link({ id, text }: { id: string; text?: string }) {
  const { reveal } = useEditor();
  return <button type="button" className="link" title={id} onClick={() => reveal(id)}>{text ?? shortName(id)}</button>;
}
