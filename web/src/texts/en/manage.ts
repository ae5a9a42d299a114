/** Texts of what is done to sets, composites, contexts, slaves and managers. */
export const manageTexts = {
  sets: {
    copy: 'Copy …', rename: 'Rename …', remove: 'Remove', title: { copy: 'A further configuration set', rename: 'Rename the configuration set' },
    name: 'Name of the set', like: (set: string) => `It is like ${set}.`, which: 'Parameters in it', taken: 'There is a set of this name.',
    activeStays: 'The active set can be neither renamed nor removed.', hiddenStays: 'Hidden sets are the author’s: they are only shown.', go: 'Do it',
  },
  contexts: {
    drives: 'Drives also', attach: 'Attach', detach: (name: string) => `Detach ${name}`, choose: 'Attach a component', owner: 'Owner',
    missed: (n: number) => (n === 1 ? '1 period was missed.' : `${n} periods were missed.`), without: (trouble: string) => `It runs without ${trouble}.`,
  },
  composites: {
    make: 'Make a composite …', title: 'Make a composite', name: 'Name of the composite', type: 'Type', rate: 'Rate of its context [Hz]', ports: 'Ports that it shows',
    types: {
      PeriodicECSharedComposite: 'One context drives all members', PeriodicStateSharedComposite: 'One context, and all change their state together',
      GroupingComposite: 'Each keeps its own context',
    },
    onePlace: 'The members of a composite are in one process.', dissolve: 'Dissolve', inside: 'Look inside', members: 'Members', letGo: (name: string) => `Let ${name} go`,
    takeIn: 'Take a component in', shown: (port: string) => `${port} is shown`, none: 'Nothing is in it.',
  },
  managers: {
    start: 'Start a manager …', title: 'Start a manager', name: 'Name', nameHint: 'Empty: the usual one.', host: 'Host', hostHint: 'Empty: this one.',
    fork: 'Start a slave', restart: 'Restart', stop: 'Stop', shutDown: 'Shut down', stopHint: 'It makes all again at its next start.',
    shutDownHint: 'It forgets all that it held.', endSlave: 'End the slave', modules: 'Loaded modules', forget: (module: string) => `Forget ${module}`,
    noModules: 'No module is loaded.', forgetZombies: (n: number) => (n === 1 ? 'Forget the zombie' : `Forget ${n} zombies`),
  },
  label: {
    addSet: (name: string, set: string) => `Add set ${set} to ${name}`, renameSet: (name: string, set: string, to: string) => `Rename set ${set} of ${name} to ${to}`,
    removeSet: (name: string, set: string) => `Remove set ${set} of ${name}`, attach: (guest: string, name: string) => `Attach ${guest} to ${name}`,
    detach: (guest: string, name: string) => `Detach ${guest} from ${name}`, compose: (name: string) => `Make ${name}`, dissolve: (name: string) => `Dissolve ${name}`,
    takeIn: (member: string, name: string) => `Take ${member} into ${name}`, letGo: (member: string, name: string) => `Let ${member} go from ${name}`,
    show: (port: string, name: string) => `Show ${port} at ${name}`, hide: (port: string, name: string) => `Hide ${port} at ${name}`,
    start: (name: string) => `Start ${name}`, restart: (name: string) => `Restart ${name}`, stop: (name: string) => `Stop ${name}`,
    shutDown: (name: string) => `Shut down ${name}`, fork: (name: string) => `Start a slave of ${name}`, endSlave: (name: string) => `End ${name}`,
    unload: (module: string, name: string) => `Forget ${module} in ${name}`,
  },
  wires: {
    all: 'Disconnect all', between: (n: number) => `${n} connectors run between these ports`, pairs: 'Interfaces', pairsHint: 'Interfaces of one type belong together.',
    noPairs: 'No interface of one is used by the other.',
  },
  scope: {
    more: 'More filters', kind: 'Filter by kind', kinds: { all: 'All kinds', manager: 'Managers', slave: 'Slaves', composite: 'Composites', component: 'Components' },
    host: 'Filter by host', allHosts: 'All hosts', manager: 'Filter by manager', allManagers: 'All managers', type: 'Filter by type', allTypes: 'All types',
    near: 'Only what is connected', steps: 'Steps', nearOf: (name: string, steps: number) => (steps === 1 ? `connected with ${name}` : `within ${steps} steps of ${name}`),
    insideOf: (name: string) => `inside of ${name}`, shows: (n: number, all: number) => `${n} of ${all} components are shown`, all: 'Show all', path: 'Where you are', system: 'System',
  },
  keptEnds: 'This ends components until the manager is started again.',
};

export type ManageTexts = typeof manageTexts;
