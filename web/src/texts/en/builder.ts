/** English texts of the room that builds components. */
export const builderTexts = {
  title: 'Build a component',
  pages: {
    basic: 'Basic', activity: 'Activity', data: 'Data ports', services: 'Service ports', parameters: 'Configuration',
    machine: 'State machine', documentation: 'Documentation', language: 'Language', source: 'RTC.xml',
  },
  pagesLabel: 'Parts of the profile',
  start: {
    lead: 'Describe a component in forms. Its code is shown while you type, and is written into a folder when you say so.',
    name: 'Name of the new component', go: 'Begin', known: 'Open a profile', none: 'There is no RTC profile in the granted folders.',
    noFolder: 'No folder is granted: start with “rtkit web --root FOLDER” to write files. Forms, preview and export work without one.',
    upload: 'Read a file …', tooLarge: 'A profile has 4 MiB at most.', back: 'Back to the draft',
  },
  bar: {
    files: 'Open …', undo: 'Undo', redo: 'Redo', folder: 'Folder', export: 'Export', generate: 'Generate …', tryIt: 'Try it …',
    changed: 'changed', errors: (n: number) => (n === 1 ? '1 error' : `${n} errors`), warnings: (n: number) => (n === 1 ? '1 remark' : `${n} remarks`),
    good: 'No findings', reopen: 'The draft has changes that are not generated.',
    discard: 'Discard the draft', discarded: 'Changes that are not generated are lost. Discard the draft?',
    adds: 'Add to the package there', addsHint: 'The component is put beside those that the folder has, as one package',
  },
  outdated: {
    title: 'The profile on the disk was changed since it was opened.', compare: 'Compare', merge: 'Bring both together', take: 'Take it over', ignore: 'Keep mine',
    conflicts: 'Changed on both sides; yours was kept:',
  },
  backups: {
    open: 'Backups …', title: 'Backups', hint: 'What was replaced is kept as NAME.bak, ten copies of a file. What is put back takes the place of the file, which is kept as the latest copy.', none: 'There are no backups in this folder.',
    putBack: 'Put back', clear: (n: number) => (n === 1 ? 'Remove 1 backup' : `Remove all ${n} backups`), ask: 'They are gone then.', close: 'Close',
  },
  preview: {
    title: 'Files', code: 'Code', difference: 'Difference', whole: 'Whole file', stale: 'Being generated …', none: 'The files appear when the errors are mended.',
    fates: { written: 'is written', unchanged: 'unchanged', kept: 'kept as you changed it', conflict: 'conflict' }, fresh: 'new',
    old: 'As before the error.',
    lines: (added: number, removed: number) => `+${added} −${removed}`, skipped: (n: number) => (n === 1 ? '1 equal line' : `${n} equal lines`),
    same: 'The file on the disk is the same.', own: 'Your code: it is kept.', notes: 'Remarks', list: 'Generated files',
    onDisk: 'On the disk', generated: 'Generated', merged: 'Merged', number: 'line', gone: 'gone', came: 'new',
  },
  generate: {
    title: (name: string) => `Generate ${name}`, nothing: 'Nothing would change.', decide: 'You have changed these files outside of the marks. Choose for each:',
    choices: { keep: 'Keep mine', replace: 'Take the generated one; mine becomes NAME.bak', merge: 'Merge both; mine becomes NAME.bak' },
    cannot: 'They cannot be merged: the same lines are changed, or it is not known what yours was generated from.',
    go: 'Generate', done: (n: number) => (n === 1 ? '1 file was written.' : `${n} files were written.`), open: 'What becomes of each file',
    undecided: 'Choose for each file in conflict.',
  },
  tryIt: {
    title: (name: string) => `Try ${name} on a manager`, manager: 'Manager', none: 'No manager runs. Start one with “rtmgr start”.',
    instance: 'Name of the component', slave: 'Slave (made if it is not there)', slaveHint: 'the manager itself',
    warning: 'The code in the folder is run, with your rights.', go: 'Load and create', waiting: (id: string) => `Waiting for ${id} …`,
    first: 'Generate first: the files in the folder are not those of the form.', label: (name: string) => `Try ${name}`,
    asking: 'The manager is asked …',
  },
  source: {
    hint: 'Edit the profile as text. What it means is shown beside the present one before it is taken over.',
    look: 'Compare', take: 'Take over', back: 'Discard', comparison: 'Difference from the form', text: 'Text of the profile', equal: 'It means the same as the form.',
    present: 'Form', wished: 'Text',
  },
  list: {
    up: (name: string) => `Move ${name} up`, down: (name: string) => `Move ${name} down`, remove: (name: string) => `Remove ${name}`, unnamed: '(no name)', more: 'More', document: 'Documentation',
    addIn: 'Add an in port', addOut: 'Add an out port', addService: 'Add a service port', addInterface: 'Add an interface', addParameter: 'Add a parameter',
    addTarget: 'Add an environment', addLibrary: 'Add a library', addTransition: 'Add a transition', addLog: 'Add an entry', addMachine: 'Add a state machine',
    noPorts: 'No ports yet.', noServices: 'No service ports yet.', noParameters: 'No parameters yet.',
    machineHint: 'An event port carries the events of the machine. A drawing NAMEFSM.scxml in the folder takes precedence over this table.',
    complex: 'This constraint is edited in RTC.xml.', onlyPython: 'rtbuild generates Python; other languages are kept in the profile.',
    targets: 'Environments', libraries: 'Libraries', logs: 'Version log', transitions: 'Transitions', interfaces: 'Interfaces',
  },
  fields: {
    name: 'Name', description: 'Description', version: 'Version', vendor: 'Vendor', category: 'Category', componentType: 'Component type', activityType: 'Activity type',
    componentKind: 'Kind', maxInstances: 'Most instances', executionType: 'Execution context', executionRate: 'Rate [Hz]', abstract: 'Abstract', rtcType: 'RTC type',
    hardwareProfile: 'Hardware', portType: 'Direction', type: 'Type', variableName: 'Variable', position: 'Side', unit: 'Unit', idlFile: 'IDL file', interfaceType: 'Interface type',
    dataflowType: 'Dataflow', subscriptionType: 'Subscription', constraint: 'Constraint', comment: 'Comment', defaultValue: 'Default', widget: 'Widget', step: 'Step',
    direction: 'Direction', instanceName: 'Instance', path: 'Path', number: 'Number', semantics: 'Meaning', occurrence: 'Period', operation: 'Frequency',
    preCondition: 'Precondition', postCondition: 'Postcondition', inout: 'Inputs and outputs', algorithm: 'Algorithm', creator: 'Author', license: 'Licence', reference: 'References',
    ifdescription: 'Interfaces', docArgument: 'Arguments', docReturn: 'Returns', docException: 'Exceptions', docPreCondition: 'Precondition', docPostCondition: 'Postcondition',
    kind: 'Language', langVersion: 'Version of the language', os: 'System', osVersions: 'Its versions', cpus: 'Processors', other: 'Other', cpuOther: 'Other processors',
    source: 'From', target: 'To', condition: 'Condition', initial: 'First state', dataname: 'Data name', range: 'Range', event: 'Event', log: 'Entry',
  },
  words: { DataInPort: 'in', DataOutPort: 'out', LEFT: 'left', RIGHT: 'right', TOP: 'top', BOTTOM: 'bottom', Provided: 'provided', Required: 'required' },
};

export type BuilderTexts = typeof builderTexts;
