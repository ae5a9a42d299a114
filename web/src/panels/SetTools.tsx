import type { Component } from '../model/types';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** Copies, renames and removes the set that is shown. */
export function SetTools({ component, set }: { component: Component; set: string }) {
  const words = useTexts().manage;
  const { canChange, open, perform } = useEditor();
  const isHidden = set.startsWith('__');
  if (isHidden) return <p className="empty">{words.sets.hiddenStays}</p>;
  const isActive = set === component.active_set;
  const why = isActive ? words.sets.activeStays : undefined;
  return (
    <div className="buttons">
      <button type="button" disabled={!canChange} onClick={() => open({ kind: 'set', component: component.id, set, way: 'copy' })}>{words.sets.copy}</button>
      <button type="button" disabled={!canChange || isActive} title={why} onClick={() => open({ kind: 'set', component: component.id, set, way: 'rename' })}>{words.sets.rename}</button>
      <button type="button" disabled={!canChange || isActive} title={why}
        onClick={() => void perform([{ do: 'remove_set', component: component.id, set }], words.label.removeSet(component.name, set))}>{words.sets.remove}</button>
    </div>
  );
}
