import type { System } from '../model/system';
import type { Dialog } from '../shell/view';
import { ComposeDialog } from './ComposeDialog';
import { ConnectDialog } from './ConnectDialog';
import { CreateDialog } from './CreateDialog';
import { ExportDialog } from './ExportDialog';
import { LoadDialog } from './LoadDialog';
import { ModulesDialog } from './ModulesDialog';
import { SetDialog } from './SetDialog';
import { StartDialog } from './StartDialog';

/** The dialog that is open, of those that ask for what an action needs; `at` is the past moment that is shown, null for the present. */
export function Dialogs({ dialog, system, at }: { dialog: Dialog | null; system: System; at: number | null }) {
  switch (dialog?.kind) {
    case 'connect': return <ConnectDialog system={system} component={dialog.component} from={dialog.from} to={dialog.to} />;
    case 'create': return <CreateDialog system={system} manager={dialog.manager} slave={dialog.slave} />;
    case 'load': return <LoadDialog manager={dialog.manager} />;
    case 'modules': return <ModulesDialog manager={dialog.manager} />;
    case 'start': return <StartDialog />;
    case 'set': return <SetDialog system={system} asked={dialog} />;
    case 'compose': return <ComposeDialog system={system} members={dialog.members} />;
    case 'export': return <ExportDialog host={system.host} at={at} />;
    default: return null;
  }
}
