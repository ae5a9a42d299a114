import { allows, zombies, type Verb } from '../model/does';
import { lackingAt, type Needed } from '../model/rights';
import { WHOLE, isWhole } from '../model/scope';
import type { Component } from '../model/types';
import type { System } from '../model/system';
import type { History, Way } from '../model/undo';
import { useVerbs } from '../panels/useVerbs';
import { LANGUAGES, useTexts } from '../texts';
import type { Command } from './Palette';
import type { Settings } from './TopBar';
import { useEditor } from './contexts';
import { ROOM_KINDS } from './rooms';
import type { View } from './view';

export interface PaletteGiven {
  system: System; view: View; selected: readonly Component[]; history: History; settings: Settings;
  onMove: (way: Way) => Promise<void>; onConnect: () => void; onRemove: () => void;
}

/** The actions that make sense now, as rows of the palette. */
export function usePaletteActions({ system, view, selected, history, settings, onMove, onConnect, onRemove }: PaletteGiven): Command[] {
  const texts = useTexts();
  const { manage } = texts;
  const [first] = selected;
  const dead = zombies(system).length;
  const editor = useEditor();
  const verbs = useVerbs();
  const command = (name: string, run: () => void, note = ''): Command => ({ kind: 'action', name, note, run });
  const names = selected.map((one) => one.name).join(', ');
  const words: Record<Verb, string> = { ...texts.act, delete: texts.act.end };
  const may = (needed: Needed, ids = selected.map((one) => one.id)) => editor.canWrite && !lackingAt(system, ids, needed);
  const forSelected = !may('operator') ? [] : [
    ...(['activate', 'deactivate', 'reset'] as const).filter((verb) => selected.some((one) => allows(one, verb)))
      .map((verb) => command(words[verb], () => verbs.act(selected, verb), names)),
    ...(selected.length === 1 ? [command(texts.act.connect, onConnect, names)] : []),
    ...(selected.length && may('administrator') ? [command(manage.composites.make, () => editor.open({ kind: 'compose', members: selected.map((one) => one.id) }), names)] : []),
    ...(selected.length && may('administrator') ? [command(texts.act.end, onRemove, names)] : []),
  ];
  const [undo, redo] = [history.undo.at(-1), history.redo.at(-1)];
  return [
    ...forSelected,
    ...(undo && editor.canChange ? [command(texts.bar.undo, () => void onMove('undo'), undo.label)] : []),
    ...(redo && editor.canChange ? [command(texts.bar.redo, () => void onMove('redo'), redo.label)] : []),
    ...[...system.managers.values()].filter((one) => one.state === 'up' && may('administrator', [one.id])).flatMap((one) => [
      command(texts.create.open, () => editor.open({ kind: 'create', manager: one.id, slave: '' }), one.name),
      command(texts.load.open, () => editor.open({ kind: 'load', manager: one.id }), one.name),
      command(`${manage.managers.modules} …`, () => editor.open({ kind: 'modules', manager: one.id }), one.name),
    ]),
    ...(editor.canChange ? [command(manage.managers.start, () => editor.open({ kind: 'start' }))] : []),
    ...(editor.canChange && dead ? [command(manage.managers.forgetZombies(dead), () => void editor.perform([{ do: 'forget_zombies' }], manage.managers.forgetZombies(dead)))] : []),
    ...(first ? [command(manage.scope.near, () => editor.narrow({ ...WHOLE, near: first.id }), first.name)] : []),
    ...(isWhole(view.scope) ? [] : [command(manage.scope.all, () => editor.narrow(WHOLE))]),
    command(texts.exporting.open, () => editor.open({ kind: 'export' })),
    ...ROOM_KINDS.filter((kind) => kind !== view.kind).map((kind) => command(texts.bar.rooms[kind], () => editor.show(kind), kind === 'plan' ? texts.bar.plansFor : '')),
    view.kind === 'table' ? command(texts.bar.diagram, () => editor.show('diagram')) : command(texts.bar.table, () => editor.show('table')),
    ...(view.placed.size ? [command(texts.bar.arrange, editor.arrange)] : []),
    ...(['auto', 'light', 'dark'] as const).filter((theme) => theme !== settings.theme).map((theme) => command(`${texts.bar.theme}: ${texts.bar.themes[theme]}`, () => settings.setTheme(theme))),
    ...(['en', 'ja'] as const).filter((key) => key !== settings.language).map((key) => command(LANGUAGES[key].language, () => settings.setLanguage(key))),
    command(texts.keys.title, () => editor.open({ kind: 'keys' })),
  ];
}
