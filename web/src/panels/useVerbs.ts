import { disconnectActions, endText, verbActions, type Verb } from '../model/does';
import type { Component, Connector } from '../model/types';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** The actions of buttons, keys and palette, each with its label. */
export function useVerbs() {
  const texts = useTexts();
  const { perform } = useEditor();
  return {
    act: (components: readonly Component[], verb: Verb) => {
      const actions = verbActions(components, verb);
      const name = components.length === 1 ? (components[0]?.name ?? '') : texts.label.several(actions.length);
      const word = verb === 'delete' ? 'end' : verb;
      if (actions.length) void perform(actions, texts.label[word](name));
    },
    disconnect: (wires: readonly Connector[]) => {
      const [first] = wires;
      if (!first) return;
      const label = wires.length === 1
        ? texts.label.disconnect(endText(first.source), endText(first.target))
        : texts.label.disconnectSome(wires.length);
      void perform(disconnectActions(wires), label);
    },
  };
}
