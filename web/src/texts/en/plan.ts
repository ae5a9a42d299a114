import type { StepState } from '../../rooms/plan/progress';
import type { Deed, Flag } from '../../rooms/plan/types';

const deeds: Record<Deed, string> = { apply: 'Apply', restore: 'Restore', start: 'Start', stop: 'Stop', take_down: 'Take down' };
const deedHints: Record<Deed, string> = {
  apply: 'Makes what lives what the profile says, by the cheapest plan; what holds already is left as it is.',
  restore: 'Creates what is not there, connects and configures; what was made is removed again if something required fails.',
  start: 'Activates all components, in the order of the profile.',
  stop: 'Deactivates all components, in reverse order.',
  take_down: 'Removes all connections, and the components, too, if that is chosen.',
};
const flags: Record<Flag, string> = {
  replace: 'Replace what cannot be changed in place', prune: 'End and disconnect what the profile does not name', rollback: 'Go back if a step fails',
  'stand-in': 'Stand-ins for missing modules', 'no-create': 'Create no components', 'strict-path': 'Ends of connectors must tell the path',
  exit: 'End the components, too', uninstall: 'Remove packages that were installed for it',
};
const states: Record<StepState, string> = { waiting: 'waits', begun: 'under way', done: 'done', held: 'was so already', failed: 'failed', left: 'not done' };

/** Texts of the room of plans. */
export const planTexts = {
  title: 'Plans', tabs: { do: 'Do', compare: 'Compare', order: 'Order' }, files: 'System profiles', live: 'What lives now', jobs: 'Plans at work',
  noFolder: 'The page may use no folder. Start it with “rtkit web --root FOLDER” to use system profiles.', noFiles: 'No system profile is there yet.',
  save: 'Save what lives', saveAs: 'As file', replaceFile: 'Replace the file', saveLabel: (file: string) => `Save the system as ${file}`,
  deed: 'What to do', deeds, deedHints, flags, options: 'Options', state: 'Components are to be', goal: { active: 'active', inactive: 'inactive', any: 'as they are' },
  liveOnly: 'Apply, restore, compare and order need a file. Save what lives, or choose a file.',
  noFile: (file: string) => `The page was granted no such file: ${file}`,
  hosts: 'Hosts, values, prefix', host: 'Host', component: 'Component', from: 'Path in the profile', to: 'Goes to host',
  parts: 'What is taken, and where it goes', partsOf: (n: number, all: number) => `${n} of ${all} components`, place2: 'Goes to', sets: 'Configuration', wires: 'Connectors',
  allSets: 'Configuration: all or none', allWires: 'Connectors: all or none', variables: 'Variables', prefix: 'Text before all names', value: 'Value',
  plan: 'Show the plan', planning: 'It is being planned …', go: (deed: string) => `${deed} now`, nothing: 'Nothing is to be done: everything is as wanted.',
  steps: (n: number) => (n === 1 ? '1 step' : `${n} steps`), cost: (cost: number) => `cost ${cost}`, optimal: 'proved cheapest', gap: (gap: number) => `at most ${gap} above the cheapest`,
  kept: (managers: number, components: number, connections: number) => `Kept: managers ${managers} · components ${components} · connections ${connections}`,
  layer: (n: number) => `Layer ${n}`, atOnce: (n: number) => `${n} at once`, checks: (n: number) => (n === 1 ? '1 check first' : `${n} checks first`),
  step: 'Step', change: 'Change', costHead: 'Cost', took: 'Took', ms: (n: number) => `${n} ms`, held: (n: number) => (n === 1 ? '1 thing is so already' : `${n} things are so already`), stateHead: 'State', required: 'required', costFrom: { table: '', measured: 'measured', profile: 'profile', user: 'user' } as Record<string, string>,
  states, command: 'Command', copy: 'Copy', copied: 'Copied', notes: 'Notes', of: (done: number, all: number) => `${done} of ${all} done`,
  runs: 'at work', done: 'done', failed: 'failed', stopped: 'stopped', stop: 'Stop', stopping: 'It is being stopped …', retry: 'Retry what failed', retryHint: 'What is done already is left as it is', left: (n: number) => (n === 1 ? '1 step was not done' : `${n} steps were not done`), anew: (reason: string) => `Planned anew: ${reason}`, back: 'Back to the plan',
  trouble: 'What went wrong', noJob: 'This plan is no longer known.', loading: 'Loading …',
  compareWith: 'with', compareState: 'Components are to be', compare: 'Compare', same: 'Nothing deviates.', differs: (n: number) => (n === 1 ? '1 difference' : `${n} differences`),
  verdictSame: 'as wanted', verdictDiffers: 'deviates', optional: 'not required', wanted: 'profile', found: 'lives', picture: 'Both systems in one picture',
  marks: { '': 'the same', '+': 'added', '-': 'missing', '~': 'changed' }, compareStates: { active: 'active', inactive: 'inactive', unknown: 'in any state' },
  order: 'Order', orders: {
    activation: 'Activation', deactivation: 'Deactivation', 'start-up': 'Start-up', 'shut-down': 'Shut-down', resetting: 'Resetting', initializing: 'Initialising', finalizing: 'Finalising',
  } as Record<string, string>,
  noOrder: 'The profile leaves this order open.', place: 'Place', wait: 'Waits [ms]', after: 'After', nobody: 'nobody', timeout: 'At most [ms]', sent: 'told is enough',
  up: (name: string) => `${name} earlier`, down: (name: string) => `${name} later`, remove: (name: string) => `Remove ${name}`, add: 'Add a component', write: 'Write the order',
  writeLabel: (order: string, file: string) => `Write the order ${order} into ${file}`,
};

export type PlanTexts = typeof planTexts;
