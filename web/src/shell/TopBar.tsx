import { countsIn } from '../canvas/graph';
import { suffices } from '../model/rights';
import type { System } from '../model/system';
import type { Entry, History, Way } from '../model/undo';
import { Counts } from '../parts/Counts';
import { Icon, type IconName } from '../parts/icons';
import { LANGUAGES, useTexts, type Language } from '../texts';
import { useEditor } from './contexts';
import { ROOM_KINDS, isAboutWhatLives, isRoom } from './rooms';
import type { Theme } from './theme';
import type { Panel, View } from './view';

export interface Settings { theme: Theme; setTheme: (theme: Theme) => void; language: Language; setLanguage: (language: Language) => void }

interface Props { system: System; view: View; history: History; settings: Settings; onMove: (way: Way) => void }

const PANELS: readonly [Panel, IconName][] = [['tree', 'left'], ['events', 'bottom'], ['inspector', 'right']];

export function TopBar({ system, view, history, settings, onMove }: Props) {
  const texts = useTexts();
  const { open, show, arrange, togglePanel, canChange } = useEditor();
  const [undo, redo] = [history.undo.at(-1), history.redo.at(-1)];
  const limited = [...system.managers.values()].filter(({ rights }) => !suffices(rights, 'administrator'));
  const named = ({ label, refusal }: Entry) => (refusal ? texts.bar.refused(label, refusal) : label);
  return (
    <header className="bar">
      <div className="row">
        <h1><img src="/icon.svg" alt="" width="20" height="20" />rtkit <span>{system.host}</span></h1>
        <Counts counts={countsIn(system.components.values())} />
        {system.isReadOnly && <span className="badge" title={texts.link.readOnlyHint}>{texts.link.readOnly}</span>}
        {limited.map(({ id, host, rights }) => rights && <span key={id} className="badge" title={texts.rights[rights.role === 'operator' ? 'mayNotMake' : 'mayLook'](rights.name, texts.rights.roles[rights.role], host)}>{texts.rights.at(texts.rights.roles[rights.role], host)}</span>)}
        <button type="button" className="search" onClick={() => open({ kind: 'palette' })}><Icon name="search" /><span>{texts.bar.search}</span><kbd aria-hidden="true">Ctrl K</kbd></button>
        <select aria-label={texts.bar.theme} title={texts.bar.theme} value={settings.theme} onChange={(event) => settings.setTheme(event.target.value as Theme)}>
          {(['auto', 'light', 'dark'] as const).map((theme) => <option key={theme} value={theme}>{texts.bar.themes[theme]}</option>)}
        </select>
        <select aria-label={texts.bar.languageLabel} title={texts.bar.languageLabel} value={settings.language} onChange={(event) => settings.setLanguage(event.target.value as Language)}>
          {Object.entries(LANGUAGES).map(([key, { language }]) => <option key={key} value={key} lang={key}>{language}</option>)}
        </select>
        <IconButton icon="help" label={`${texts.bar.help} (?)`} onClick={() => open({ kind: 'keys' })} />
      </div>
      <div className="row">
        <div className="group views" role="group" aria-label={texts.bar.views}>
          {(['diagram', 'table'] as const).map((kind) => <button key={kind} type="button" aria-pressed={view.kind === kind} onClick={() => show(kind)}>{texts.bar[kind]}</button>)}
          {ROOM_KINDS.map((kind) => <button key={kind} type="button" aria-pressed={view.kind === kind} onClick={() => show(kind)}>{texts.bar.rooms[kind]}</button>)}
        </div>
        {/* These are about what lives; rooms have tools of their own. */}
        {isAboutWhatLives(view.kind) && (
          <div className="tools">
            <div className="group">
              <IconButton icon="undo" label={undo ? texts.bar.undoOf(named(undo)) : texts.bar.undo} isDisabled={!undo || !canChange} onClick={() => onMove('undo')} />
              <IconButton icon="redo" label={redo ? texts.bar.redoOf(named(redo)) : texts.bar.redo} isDisabled={!redo || !canChange} onClick={() => onMove('redo')} />
              {!isRoom(view.kind) && <button type="button" disabled={!view.placed.size} onClick={arrange}><Icon name="arrange" />{texts.bar.arrange}</button>}
            </div>
            {!isRoom(view.kind) && <button type="button" onClick={() => open({ kind: 'export' })}>{texts.exporting.open}</button>}
            {!isRoom(view.kind) && <div className="group">
              {PANELS.map(([panel, icon]) => (
                <IconButton key={panel} icon={icon} isPressed={view.panels[panel]} onClick={() => togglePanel(panel)}
                  label={view.panels[panel] ? texts.bar.hide(texts.bar[panel]) : texts.bar.show(texts.bar[panel])} />
              ))}
            </div>}
          </div>
        )}
      </div>
    </header>
  );
}

interface IconButtonProps { icon: IconName; label: string; isDisabled?: boolean; isPressed?: boolean; onClick: () => void }

function IconButton({ icon, label, isDisabled = false, isPressed, onClick }: IconButtonProps) {
  return <button type="button" className="icon-button" aria-label={label} title={label} aria-pressed={isPressed} disabled={isDisabled} onClick={onClick}><Icon name={icon} /></button>;
}
