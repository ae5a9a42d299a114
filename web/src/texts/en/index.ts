import { manageTexts } from './manage';

/** English texts. Those of other languages have the same keys: `Texts` is the type of this catalogue. */
export const en = {
  key: 'en' as 'en' | 'ja',
  language: 'English',
  looks: {
    active: 'Active', inactive: 'Inactive', error: 'Error', created: 'Created', unknown: 'Unknown',
    zombie: 'Zombie', stuck: 'Stuck', unreachable: 'Unreachable', restarting: 'Restarting',
  },
  managerStates: { up: 'up', gone: 'gone' },
  processStates: { up: 'up', starting: 'starting', stopped: 'stopped', silent: 'silent', lost: 'lost' },
  directions: { in: 'in', out: 'out', service: 'service' },
  contextKinds: { PERIODIC: 'periodic', EVENT_DRIVEN: 'event-driven', OTHER: 'other' },

  link: {
    connecting: 'Connecting to the server …',
    lost: (since: string) => `There is no connection to the server. The picture is as it was at ${since}. The page connects again by itself.`,
    managerGone: (names: string) => `The server has lost ${names}. What you see of it is the last that is known.`,
    readOnly: 'Read-only',
    readOnlyHint: 'The server was started with --read-only: nothing can be changed from here.',
  },
  rights: {
    roles: { administrator: 'administrator', operator: 'operator', viewer: 'viewer', component: 'component' },
    at: (role: string, host: string) => `${role} at ${host}`,
    mayLook: (name: string, role: string, host: string) => `${name} is ${role} at ${host} and may only look. Changes take the role operator; to make and end things takes administrator.`,
    mayNotMake: (name: string, role: string, host: string) => `${name} is ${role} at ${host} and may change what is there. To make and end things takes the role administrator.`,
  },
  locked: {
    refused: 'The server refuses this token: it is another one after each start of “rtkit web”.',
    title: 'This page needs a token',
    body: 'Open the address that “rtkit web” prints, or paste it here.',
    field: 'Address or token',
    open: 'Open',
  },

  bar: {
    search: 'Search or do …', views: 'View', rooms: { plan: 'Plans', document: 'Offline', properties: 'Properties', log: 'Log', jobs: 'Jobs', machine: 'State machines', builder: 'Builder' }, plansFor: 'save, apply, restore, compare', roomLoading: 'Loading …', diagram: 'Diagram', table: 'Table',
    undo: 'Undo', redo: 'Redo', arrange: 'Arrange', fit: 'Fit', zoomIn: 'Zoom in', zoomOut: 'Zoom out',
    help: 'Keys', theme: 'Colours', themes: { auto: 'Auto', light: 'Light', dark: 'Dark' },
    languageLabel: 'Language', tree: 'Tree', inspector: 'Inspector', events: 'Events',
    undoOf: (label: string) => `Undo: ${label}`, redoOf: (label: string) => `Redo: ${label}`, refused: (label: string, why: string) => `${label} (refused: ${why})`,
    show: (panel: string) => `Show: ${panel}`, hide: (panel: string) => `Hide: ${panel}`,
  },

  canvas: {
    label: 'Diagram of components and connectors',
    empty: 'No component runs. Start a manager with “rtmgr start”, or load a system with “rtapply”.',
    emptyManager: 'No component runs. Select a manager to create one, or bring up a system by “Plans”.',
    loading: 'Drawing …',
    fold: (name: string) => `Fold ${name}`, unfold: (name: string) => `Unfold ${name}`,
    
    kinds: { manager: 'manager', process: 'slave', composite: 'composite', component: 'component' },
    component: (name: string, type: string, state: string, ports: number) => `${name}, ${type}, ${state}, ${ports === 1 ? '1 port' : `${ports} ports`}`,
    wire: (source: string, target: string) => `Connector from ${source} to ${target}`,
    components: (n: number) => (n === 1 ? '1 component' : `${n} components`),
    release: 'Release on a lit port to connect.',
    asking: 'The server is asked which ports fit …',
    noneFits: 'No port fits this one.',
    minimap: 'Overview map',
  },

  tree: {
    title: 'Tree', filter: 'Filter by text', filterState: 'Filter by state', all: 'All states',
    troubled: 'In trouble', none: 'Nothing matches the filter.', 
  },

  inspector: {
    title: 'Inspector', overview: 'Overview', state: 'State', since: 'since', type: 'Type', process: 'Process', manager: 'Manager',
    host: 'Host', pid: 'Process id', version: 'Version', path: 'Path', composite: 'Part of', members: 'Members', description: 'Description',
    actions: 'Actions', contexts: 'Execution contexts', rate: 'Rate', hz: 'Hz', running: 'runs', stopped: 'stopped', set: 'Set',
    ports: 'Ports', connectors: 'Connectors', noPorts: 'This component has no ports.', free: 'not connected',
    configuration: 'Configuration', setName: 'Configuration set', activeSet: 'active', activateSet: 'Activate this set',
    noParameters: 'This set has no parameters.', apply: 'Apply', revert: 'Discard', changed: 'changed',
    
    values: 'Values', valuesOf: (port: string) => `Values of ${port}`, properties: 'Properties', noProperties: 'There are no properties.', source: 'From', target: 'To', trouble: 'Trouble', written: 'Written',
    several: (n: number) => `${n} are selected`, countByState: 'Components by state', managers: 'Managers', hidden: 'Show hidden sets',
    nothing: 'Select a component, a connector or a manager to see it here.', 
    connect: 'Connect …',
  },
  misfit: {
    notANumber: 'This is not a number.', mustSatisfy: (rule: string) => `The value must satisfy ${rule}.`,
    notOffered: (value: string) => `“${value}” is not one of the choices.`,
  },
  list: { up: (item: string) => `Move ${item} up`, down: (item: string) => `Move ${item} down` },

  act: {
    activate: 'Activate', deactivate: 'Deactivate', reset: 'Reset', end: 'End', forget: 'Forget',
    connect: 'Connect', disconnect: 'Disconnect', 
  },
  /** Names of what was done, for toasts and for undo. */
  label: {
    activate: (name: string) => `Activate ${name}`, deactivate: (name: string) => `Deactivate ${name}`,
    reset: (name: string) => `Reset ${name}`, end: (name: string) => `End ${name}`,
    connect: (source: string, target: string) => `Connect ${source} with ${target}`,
    disconnect: (source: string, target: string) => `Disconnect ${source} from ${target}`,
    disconnectSome: (n: number) => `Disconnect ${n} connectors`,
    configure: (name: string) => `Configure ${name}`, activateSet: (name: string, set: string) => `Activate set ${set} of ${name}`,
    save: (file: string) => `Save the system as ${file}`,
    create: (name: string, manager: string) => `Create ${name} in ${manager}`, load: (module: string, manager: string) => `Load ${module} into ${manager}`,
    set: (target: string) => `Set ${target}`,
    rate: (name: string, hz: string) => `Set the rate of ${name} to ${hz} Hz`,
    several: (n: number) => `${n} components`, undo: (label: string) => `Undo: ${label}`, redo: (label: string) => `Redo: ${label}`,
  },

  plan: {
    title: 'Plan', lead: (n: number) => (n === 1 ? 'This will be done:' : `These ${n} steps will be done in order:`),
    ends: 'This ends components. It cannot be undone.', noUndo: (why: string) => `This cannot be undone: ${why}.`,
    go: 'Do it', cancel: 'Cancel', 
  },
  toast: {
    region: 'Results', copy: 'Copy as command', copied: 'Copied', close: 'Close', undo: 'Undo',
    failed: (label: string) => `${label}: this failed.`,
    partly: (done: number, all: number) => `${done} of ${all} steps were done.`,
    drop: 'Take it off the list',
    nothingToUndo: 'There is nothing to undo.', nothingToRedo: 'There is nothing to redo.',
  },

  connect: {
    title: 'Connect', from: 'From port', to: 'To port', filter: 'Filter the ports', name: 'Name of the connector',
    nameHint: 'Empty: the server chooses one.', buffers: 'Buffers', none: 'No port fits.',
    unfit: (n: number) => `Ports that do not fit (${n})`, byDefault: 'by default', asking: 'The server is asked which ports fit …',
    dataflow: 'Data flow', subscription: 'Subscription', policy: 'Push policy', rate: 'Push rate [Hz]', skip: 'Skip count',
    transport: 'Transport', atSource: 'At the out port', atTarget: 'At the in port', length: 'Length', full: 'When full', empty: 'When empty',
    further: 'Further properties, one KEY=VALUE a line', badLine: (line: string) => `“${line}” is not KEY=VALUE.`,
    pushPolicies: { new: 'new: the newest value', all: 'all: all that wait', fifo: 'fifo: one after the other', skip: 'skip: every n-th' },
    subscriptions: { new: 'new: a thread sends', flush: 'flush: within the write call', periodic: 'periodic: at a rate' },
    dataflows: { push: 'push: the writer sends', pull: 'pull: the reader fetches' },
  },

  create: {
    open: 'Create a component …', title: (manager: string) => `Create a component in ${manager}`, filter: 'Filter the types', go: 'Create',
    asking: 'The manager is asked what it can make …', noType: 'No type matches.',
    instance: 'Name of the instance', instanceHint: 'Empty: the manager chooses one.',
    slave: 'Slave', slaveHint: 'Empty: the manager itself.', parameters: 'Parameters, one KEY=VALUE a line',
  },
  load: {
    open: 'Load a module …', title: (manager: string) => `Load a module into ${manager}`, path: 'File of the module', go: 'Load',
    init: 'Init function', initHint: 'Empty: the usual one.',
    found: (n: number) => (n === 0 ? 'The manager finds no module that is not loaded.' : `The manager finds ${n} that are not loaded.`),
  },
  exporting: {
    open: 'Export …', title: 'Save the picture of the system', print: 'Print …', printHint: 'what is seen now', asOf: (time: string) => `The system as it was at ${time}.`, forms: { png: 'PNG', svg: 'SVG', dot: 'dot', mermaid: 'Mermaid', text: 'Text' },
    hints: { png: 'an image of points, for slides and mails', svg: 'a picture', dot: 'for Graphviz', mermaid: 'for Markdown pages', text: '80 columns wide' },
  },

  palette: {
    title: 'Search or do', placeholder: 'Component, port, type or action', none: 'Nothing matches.',
    kinds: { action: 'action', component: 'component', port: 'port', type: 'type', manager: 'manager' },
    hint: 'Enter goes there or does it. Escape closes.',
  },
  events: {
    title: 'Events', filter: 'Filter the events', pause: 'Pause', resume: 'Go on', time: 'Time', path: 'Path', event: 'Event', detail: 'Detail',
    none: 'Nothing has happened yet.', waiting: (n: number) => `${n} more`,
  },
  past: {
    line: 'Time line: arrow keys go from change to change', now: 'Now', at: (time: string, changes: number) => `${time}, after ${changes} changes`,
    asItWas: (time: string) => `As it was at ${time}. Nothing can be changed here; values that flowed then are not known.`, loading: 'The past is being loaded …',
  },
  table: {
    label: 'Components, ports and connectors as tables', components: 'Components', ports: 'Ports', connectors: 'Connectors', filter: 'Filter the tables',
    name: 'Name', type: 'Type', state: 'State', remark: 'Remark', process: 'Process', actions: 'Actions', component: 'Component', port: 'Port',
    direction: 'Direction', connected: 'Connected with', source: 'From', target: 'To', rate: 'Rate', trouble: 'Trouble',
    noRows: 'There is nothing to show.', more: (n: number) => `${n} more rows; narrow the filter to see them.`,
  },
  keys: {
    title: 'Keys', close: 'Close',
    rows: [
      ['Tab', 'goes to the next component'], ['Arrow keys', 'go to the component that lies there; without a selection, move the view'],
      ['Shift + arrow keys', 'add the component that lies there to the selection'], ['Ctrl + A', 'selects all components'],
      ['Alt + arrow keys', 'move the selected components'], ['Enter', 'opens the inspector'], ['Escape', 'clears the selection'],
      ['C', 'connects a port of the selected component'], ['Delete', 'disconnects or ends what is selected'],
      ['Ctrl + Z', 'undoes the last action'], ['Ctrl + Shift + Z', 'redoes it'], ['Ctrl + K  or  /', 'searches components, ports, types and actions'],
      ['F', 'shows the whole picture'], ['+  −', 'zoom'], ['T', 'changes between diagram and table'], ['?', 'shows these keys'],
    ] as [string, string][],
  },
  manage: manageTexts,
  live: {
    became: (name: string, state: string) => `${name}: ${state}`, more: (n: number) => `and ${n} more`, gone: (name: string) => `${name} has gone`,
  },
};

export type Texts = typeof en;
