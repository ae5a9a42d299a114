/** Texts of the room of state machines. */
export const machineTexts = {
  title: 'State machines', none: 'No state machine is served. Make one here, or with “rtmgr -c StateMachine”.', asking: 'The services are asked …',
  name: 'Machine', state: 'Active state', run: 'Run', refresh: 'Look again', draw: 'New machine', all: 'All machines',
  runs: { stopped: 'stopped', running: 'running', paused: 'paused', done: 'done' },
  connecting: 'The machine is asked …', gone: (why: string) => `It does not answer: ${why}`, newTitle: 'New machine',
  views: 'View of the machine', chart: 'Chart', outline: 'Outline', chartLabel: 'State chart', empty: 'There is no state yet. Add one with “State”, or with the key N.',
  minimap: 'Overview map of the machine',
  active: 'active', initial: 'initial', final: 'final', composite: 'with states inside', plain: 'state',
  nodeLabel: (path: string, words: string) => (words ? `${path}, ${words}` : path),
  wayLabel: (from: string, to: string, text: string) => `Transition from ${from} to ${to || 'nowhere'}: ${text}`,
  newWay: (name: string) => `Draw a transition from ${name} to another state`, release: 'Release on a state: the transition leads there.',
  signs: { '+': 'new', '−': 'removed', '~': 'changed' },

  controls: 'Run', start: 'Start', pause: 'Pause', step: 'Step', stop: 'Stop', resume: 'Go on',
  event: 'Event', send: 'Send', waits: 'Events that it waits for', sendOf: (name: string) => `Send the event ${name}`,
  last: 'Last transition', atTime: (time: string) => `at ${time}`, withData: (data: string) => `by ${data}`,

  edit: 'Edit', addState: 'State', addInside: 'State inside', addFinal: 'Final state', addWay: 'Transition', remove: 'Delete', undo: 'Undo', redo: 'Redo',
  apply: 'Apply …', create: 'Create …', discard: 'Discard', files: 'Open, save …',
  changes: (n: number) => (n === 1 ? '1 change is not applied.' : `${n} changes are not applied.`),
  stale: 'The machine was edited meanwhile by somebody else: what you drew would be refused.',
  keep: 'Keep mine, over theirs', takeTheirs: 'Take theirs',
  problems: 'What is wrong', problemOf: (state: string, text: string) => (state ? `${state}: ${text}` : text), whole: 'Nothing is wrong.', odd: 'odd',

  inspector: 'Inspector', machine: 'Machine', stateOf: (path: string) => `State ${path}`, wayOf: (path: string) => `Transition of ${path}`,
  nothing: 'Select a state or a transition to edit it here.',
  fields: {
    name: 'Name', doc: 'Description', outer: 'Inside', outermost: 'nothing: outermost', initial: 'Initial state', isInitial: 'Entered first', isFinal: 'Final: what is round it ends here',
    entry: 'When entered', exit: 'When left', do: 'Repeated while active', transitions: 'Transitions, tried in this order', variables: 'Variables',
    to: 'Leads to', stays: 'nowhere: no state is left', on: 'On the event', when: 'When', after: 'After [s]', actions: 'Actions on the way',
    onHint: 'none, * for any', whenHint: 'robots/r1.x > 1 and light.on', first: 'First value', value: 'Value', now: 'Now', variable: 'Variable',
  },
  nameFaults: { bad: 'A name has letters, digits, - and _, and begins with a letter.', taken: 'There is a state of that name.' },
  actionKinds: { set: 'SET a property', assign: 'Set a variable', raise: 'Raise an event' },
  hows: { value: 'to the value', expression: 'computed as', get: 'got from' },
  target: 'What', kind: 'Action', how: 'How', every: 'Every [s]', addAction: 'Action', addVariable: 'Variable',
  removeOf: (what: string) => `Remove ${what}`, upOf: (what: string) => `Try ${what} earlier`, downOf: (what: string) => `Try ${what} later`, setOf: (name: string) => `Set the variable ${name} now`, set: 'Set',
  atOnce: 'at once', open: 'Open',

  table: { state: 'State', kind: 'Kind', actions: 'Actions', transitions: 'Transitions', edit: 'Edit' },

  log: 'History', logAll: 'All', logTransitions: 'Transitions', time: 'Time', what: 'What', text: 'Text', noLog: 'Nothing has happened yet.',
  kinds: {
    run: 'run', value: 'value', event: 'event', time: 'time', transition: 'transition', set: 'SET', assign: 'variable', failed: 'failed', edited: 'edited', lost: 'lost',
  } as Record<string, string>,

  diff: {
    title: (name: string) => `Apply the edit to ${name}`, lead: 'All of it comes into force between two steps, or nothing.', machine: 'The machine',
    gotoLead: (state: string) => `The active state ${state} would be gone.`, goto: 'Where is it to go?', choose: 'Choose a state', wrong: 'This cannot be applied yet:',
    go: 'Apply', cancel: 'Cancel', none: 'Nothing was changed.', reformatted: 'Comments in its text, and how that is laid out, are not kept.',
    parts: {
      initial: 'initial state', final: 'final', doc: 'description', entry: 'when entered', exit: 'when left', do: 'repeated', variables: 'variables', name: 'name', order: 'order', atOnce: 'at once',
    },
  },
  creating: {
    title: 'Create a state machine', service: 'Name of the service', manager: 'Manager', instance: 'Name of the component', go: 'Create', noManager: 'No manager runs: start one with “rtmgr start”.',
    wrong: 'Mend first what is wrong in the machine.',
  },
  saving: {
    title: 'Files of the machine', what: 'What is saved, and where it is opened', whole: 'The whole machine', part: (path: string) => `The state ${path} with all inside it; what is opened is put inside it`, download: 'Save what is drawn', forms: { turtle: 'RDF (Turtle)', xml: 'RDF/XML', scxml: 'SCXML' }, upload: 'Open a file', browse: 'Choose a file …',
    from: 'From a storage or folder', source: 'Property of a storage, or file', fetch: 'Open', to: 'Save the machine that lives', target: 'Property of a storage, or file in a folder',
    save: 'Save', replace: 'Replace the file if it is there', noFolder: 'The page may use no folder. Start it with “rtkit web --root FOLDER” to open and save machines there.',
    notApplied: 'What is not applied is not saved by this.', close: 'Close',
  },
  label: {
    edit: (name: string) => `Edit ${name}`, run: (name: string, word: string) => `${name}: ${word}`, event: (name: string, event: string) => `Send ${event} to ${name}`,
    variable: (name: string, variable: string) => `Set ${variable} of ${name}`, save: (name: string, file: string) => `Save ${name} as ${file}`, create: (name: string) => `Create the machine ${name}`,
  },
  connectTitle: (name: string) => `Draw a transition from ${name}`, connectGo: 'Draw',
  keys: 'Keys: arrows go from state to state, Enter edits, N adds a state, Shift+N one inside, C draws a transition, Delete removes, Ctrl+Z undoes.',
};

export type MachineTexts = typeof machineTexts;
