import { allows, type Verb } from '../model/does';
import type { Component } from '../model/types';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { useVerbs } from './useVerbs';

const VERBS: readonly Verb[] = ['activate', 'deactivate', 'reset', 'delete'];

/** Activate, deactivate, reset and end for one component or several; what fits none of them is greyed. */
export function VerbButtons({ components }: { components: readonly Component[] }) {
  const texts = useTexts();
  const { canChange, canMake } = useEditor();
  const { act } = useVerbs();
  const isDead = components.every((component) => component.look === 'zombie');
  const words = { ...texts.act, delete: isDead ? texts.act.forget : texts.act.end };
  return (
    <div className="buttons">
      {VERBS.map((verb) => (
        <button key={verb} type="button" className={verb === 'delete' ? 'danger' : ''}
          disabled={!(verb === 'delete' ? canMake : canChange) || !components.some((component) => allows(component, verb))} onClick={() => act(components, verb)}>
          {words[verb]}
        </button>
      ))}
    </div>
  );
}
