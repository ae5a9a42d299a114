/** Texts of the room of offline documents. */
export const documentTexts = {
  title: 'Offline diagrams', lead: 'System profiles are opened and edited here with nothing running.', opening: 'Opening …',
  noFolder: 'No folder is granted to this page: start it as rtkit web --root FOLDER.', noFiles: 'There is no file in the granted folders.',
  files: 'Files in the granted folders', openDocuments: 'Open documents', newOne: 'New diagram', newName: 'Name of the system', create: 'Begin',
  filter: 'Filter files', unsaved: 'not saved yet', changed: 'changed', close: 'Close', closeAsk: (name: string) => `${name} has changes that are not saved. They are lost when it is closed.`,
  closeAnyway: 'Close without saving', cancel: 'Cancel', all: 'All files', back: 'Back to all files',
  save: 'Save', saveAs: 'Save as …', saveTitle: 'Save as', path: 'File (.xml, .yaml or .json)', replace: 'Replace the file that is there', replaceAsk: 'Replace it',
  undo: 'Undo', redo: 'Redo', undoOf: (what: string) => `Undo: ${what}`, redoOf: (what: string) => `Redo: ${what}`, arrange: 'Arrange all', restore: 'Restore …',
  restoreHint: 'Plans what brings the live system to this file', check: 'Copy the command of the check', copied: 'Copied',
  types: 'Component types', typeFilter: 'Filter types', typeHint: 'Enter adds a type, or drag it into the diagram.', noTypes: 'No component profile is found in the granted folders.', looking: 'Looking for profiles …',
  ports: (n: number) => (n === 1 ? '1 port' : `${n} ports`),
  findings: 'Findings', clean: 'The checks find nothing.', counts: (errors: number, warnings: number, notes: number) => `${errors} errors, ${warnings} warnings, ${notes} notes`,
  severity: { error: 'error', warning: 'warning', note: 'note' }, untyped: 'type unknown', required: 'required', optional: 'optional', included: 'included', fine: 'checked',
  emptyDiagram: 'This diagram is empty: add a component type from the list.',
  inspector: 'Selection', component: 'Component', connector: 'Connector', system: 'System', name: 'Name', rename: 'Rename', type: 'Type', address: 'Path', source: 'Profile of the type', from: 'From',
  readOnlyPart: (file: string) => `It comes from ${file}, which this profile includes: change it there.`, direction: 'Direction', required2: 'Required: without it the system does not count as restored', remove: 'Remove',
  portsTitle: 'Ports', connect: 'Connect …', connectTitle: (port: string) => `Connect ${port}`, fits: 'Ports that fit', fitsNot: (n: number) => `Ports that do not fit (${n})`, noneFits: 'No port fits.', choosePort: 'Port',
  disconnect: 'Disconnect', configuration: 'Configuration sets', set: 'Set', active: 'active', activate: 'Make active', addSet: 'Add set', copySet: 'Copy set', removeSet: 'Remove set', setName: 'Name of the new set',
  noSets: 'It has no configuration set.', addParameter: 'Add parameter', parameter: 'Parameter', value: 'Value', apply: 'Apply', removeParameter: (name: string) => `Remove the parameter ${name}`,
  properties: 'Properties', addProperty: 'Add property', removeProperty: (name: string) => `Remove the property ${name}`, data: 'Data type', how: 'How', ends: 'Ends', bends: 'Bend points',
  several: (n: number) => `${n} things are selected`, profile: 'Profile', vendor: 'Vendor', version: 'Version', abstract: 'Description', comment: 'Comment', created: 'Created', updated: 'Updated', log: 'Update log (one entry a line)',
  variables: 'Variables', noValue: 'a value must be given', includes: 'Included files', prefix: 'prefix', resolved: 'Shown with the values of its variables and with what it includes.',
  did: (what: string) => `Done: ${what}`, saved: (file: string) => `Saved as ${file}`, gone: 'This document was closed.',
};

export type DocumentTexts = typeof documentTexts;
