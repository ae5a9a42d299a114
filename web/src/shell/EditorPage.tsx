import { Suspense, useCallback, useEffect, useMemo, useReducer, useState } from 'react';

import { Dialogs } from '../actions/Dialogs';
import { PlanDialog } from '../actions/PlanDialog';
import { ToastList } from '../actions/ToastList';
import { useActions } from '../actions/useActions';
import { useToasts } from '../actions/useToasts';
import { Canvas } from '../canvas/Canvas';
import { removeActions, wireText } from '../model/does';
import { lackingAt, type Needed } from '../model/rights';
import { narrowed } from '../model/scope';
import type { System } from '../model/system';
import type { Notice } from '../model/types';
import { EventsPanel } from '../panels/EventsPanel';
import { Inspector } from '../panels/Inspector';
import { ScopeBar } from '../panels/ScopeBar';
import { TableView } from '../panels/TableView';
import { TreePanel } from '../panels/TreePanel';
import { createApi } from '../server/api';
import { createSubscriptions } from '../server/subscriptions';
import { PastBanner, TimeLine } from '../rooms/past/TimeLine';
import { usePast } from '../rooms/past/usePast';
import { NO_VALUES, createValues } from '../server/values';
import { useTexts, type Texts } from '../texts';
import { Banner } from './Banner';
import { KeysDialog } from './KeysDialog';
import { LiveRegion } from './LiveRegion';
import { Palette } from './Palette';
import { TopBar, type Settings } from './TopBar';
import { EditorContext, RatesContext } from './contexts';
import { addressOf } from './address';
import { useEditorValue } from './editor';
import { ROOMS, isAboutWhatLives, isRoom } from './rooms';
import { useAddress } from './useAddress';
import { useLayout } from './useLayout';
import { useScope } from './useScope';
import { useShortcuts } from './useShortcuts';
import { useSystem } from './useSystem';
import { FIRST_VIEW, arrived, reduceView } from './view';

interface Props { token: string; settings: Settings; onDenied: () => void }

/** The editor: puts the system that the server tells, the view of this page and the actions together. */
export function EditorPage({ token, settings, onDenied }: Props) {
  const texts = useTexts();
  const [page] = useState(() => crypto.randomUUID());
  const api = useMemo(() => createApi(token, page), [token, page]);
  const subscriptions = useMemo(() => createSubscriptions(), []);
  const values = useMemo(() => createValues(api, page), [api, page]);
  const toasts = useToasts();
  const { add } = toasts;
  const onNotice = useCallback(({ level, text }: Notice) => add({ level, title: text, lines: [], command: '', canUndo: false }), [add]);
  const onError = useCallback((text: string) => onNotice({ level: 'error', text }), [onNotice]);
  const { system: live, link, lostAt } = useSystem(token, api, subscriptions, values, onNotice);
  const past = usePast(api, subscriptions, onError);
  const [view, dispatch] = useReducer(reduceView, FIRST_VIEW, (first) => arrived(first, addressOf(location.hash)));
  useAddress(view, dispatch);
  // A room is about what it holds, not about a moment of the system.
  const isPast = past.time !== null && !isRoom(view.kind);
  const system = (isPast && past.system) || live;
  const shown = useScope(system, view.scope);
  const layout = useLayout(api, system.structure, view.folded, shown, isPast ? past.layoutAt : null, onError);
  const { asked, history, perform, remember, move } = useActions(api, toasts);
  const canWrite = link === 'up' && !live.isReadOnly && !isPast;
  const editor = useEditorValue(api, subscriptions, isPast ? NO_VALUES : values, canWrite, system, dispatch, perform, remember);
  useEffect(() => {
    if (link === 'denied') onDenied();
  }, [link, onDenied]);
  const [focusCount, setFocusCount] = useState(0);

  const openInspector = () => {
    if (!view.panels.inspector) editor.togglePanel('inspector');
    setFocusCount((count) => count + 1);
  };
  const selected = view.selection.flatMap((id) => system.components.get(id) ?? []);
  const [component] = selected;
  const may = (needed: Needed) => canWrite && !lackingAt(system, view.selection, needed);
  const connect = () => {
    if (component?.ports.length && may('operator')) editor.open({ kind: 'connect', from: null, to: null, component: component.id });
  };
  const remove = () => {
    const actions = removeActions(view.selection, system);
    if (actions.length && may(actions.every((one) => one.do === 'disconnect') ? 'operator' : 'administrator')) void perform(actions, removeLabel(view.selection, system, texts));
  };
  const { dialog } = view;
  const part = useMemo(() => narrowed(system, shown), [system, shown]);
  const Room = isRoom(view.kind) ? ROOMS[view.kind] : null;
  useShortcuts({
    palette: () => editor.open({ kind: 'palette' }),
    keys: () => editor.open({ kind: 'keys' }),
    turn: () => editor.show(view.kind === 'table' ? 'diagram' : 'table'),
    // What lives is not seen in a room: there these keys are about what is.
    ...(isAboutWhatLives(view.kind) && {
      undo: () => canWrite && void move('undo'),
      redo: () => canWrite && void move('redo'),
    }),
    ...(!Room && {
      remove,
      connect,
      all: () => editor.select([...part.components.keys()]),
      clear: () => (isPast ? past.go(null) : editor.select([])),
    }),
  });
  // Panels are about what lives; a room has the whole page.
  const panels = Room ? { tree: false, inspector: false, events: false } : view.panels;

  return (
    <EditorContext value={editor}>
      <RatesContext value={system.rates}>
        <div className={`page ${link === 'up' ? '' : 'is-stale'} ${isPast ? 'is-past' : ''}`} data-tree={panels.tree} data-inspector={panels.inspector} data-events={panels.events}>
          <TopBar system={isPast ? { ...system, isReadOnly: live.isReadOnly } : live} view={view} history={history} settings={settings} onMove={(way) => void move(way)} />
          <Banner link={link} lostAt={lostAt} managers={system.managers}>{isPast && <PastBanner past={past} />}</Banner>
          {panels.tree && <TreePanel managers={system.managers} processes={system.processes} components={system.components} shown={shown} scope={view.scope} selection={view.selection} filter={view.filter} />}
          {Room ? (
            <Suspense fallback={<main className="room"><p className="empty">{texts.bar.roomLoading}</p></main>}><Room system={system} view={view} /></Suspense>
          ) : view.kind === 'table' ? <TableView system={part} filter={view.filter} /> : (
            <main className="stage">
              <ScopeBar system={system} scope={view.scope} shown={shown} />
              {layout && system.components.size > 0 && (
                <Canvas system={part} shown={shown} layout={layout} view={view} onOpen={openInspector}
                  onConnect={(from, to) => editor.open({ kind: 'connect', from, to, component: from.component })} />
              )}
              {!(layout && system.components.size) && <p className="empty">{system.isKnown && !system.components.size ? (system.managers.size ? texts.canvas.emptyManager : texts.canvas.empty) : link === 'connecting' ? texts.link.connecting : texts.canvas.loading}</p>}
            </main>
          )}
          {panels.inspector && <Inspector system={system} view={view} focusCount={focusCount} />}
          {panels.events && <EventsPanel events={system.events}><TimeLine since={live.since} events={live.events} past={past} /></EventsPanel>}
        </div>
        {dialog?.kind === 'palette' && <Palette system={system} given={{ system, view, selected, history, settings, onMove: move, onConnect: connect, onRemove: remove }} />}
        {dialog?.kind === 'keys' && <KeysDialog />}
        <Dialogs dialog={dialog} system={system} at={isPast ? past.time : null} />
        {asked && <PlanDialog asked={asked} />}
        <ToastList toasts={toasts} onUndo={() => void move('undo')} />
        <LiveRegion components={live.components} isKnown={live.isKnown} />
      </RatesContext>
    </EditorContext>
  );
}

function removeLabel(ids: readonly string[], system: System, texts: Texts): string {
  const [wires, components] = [ids.flatMap((id) => system.connectors.get(id) ?? []), ids.flatMap((id) => system.components.get(id) ?? [])];
  if (components.length) return texts.label.end(components.map((one) => one.name).join(', '));
  return wires.length === 1 && wires[0] ? `${texts.act.disconnect} ${wireText(wires[0])}` : texts.label.disconnectSome(wires.length);
}
