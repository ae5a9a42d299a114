import { useMemo, type ReactNode } from 'react';

import { lackingAt } from '../model/rights';
import type { System } from '../model/system';
import { EditorContext, useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

interface Props { system: System; ids: readonly string[] }

/** Disables the controls within of what the user of the page may not do where these things are. */
export function RightsGate({ system, ids, children }: Props & { children: ReactNode }) {
  const editor = useEditor();
  const [isFixed, isKept] = [Boolean(lackingAt(system, ids, 'operator')), Boolean(lackingAt(system, ids, 'administrator'))];
  const gated = useMemo(() => ({
    ...editor, canChange: editor.canChange && !isFixed, canMake: editor.canMake && !isKept,
  }), [editor, isFixed, isKept]);
  return <EditorContext value={gated}>{children}</EditorContext>;
}

/** Tells which right is lacking where these things are; nothing where none is. */
export function RightsNote({ system, ids }: Props) {
  const { rights: words } = useTexts();
  const manager = lackingAt(system, ids, 'operator') ?? lackingAt(system, ids, 'administrator');
  if (!manager?.rights) return null;
  const { rights, host } = manager;
  const told = rights.role === 'operator' ? words.mayNotMake : words.mayLook;
  return <p className="remark rights">{told(rights.name, words.roles[rights.role], host)}</p>;
}
