/** Texts of the room of live properties, and of its widgets. */
export const propertiesTexts = {
  heading: 'Properties', tree: 'Services, components and their properties', search: 'Search properties', nothingFound: 'Nothing is called so.',
  choose: 'Choose a service, a component or one of their properties.', asking: 'Asking …',
  silent: (why: string) => `What is shown may be old: ${why}`,
  ownPage: 'My page', addToOwn: 'Add to my page', edit: 'Put together', title: 'Title', noItems: 'No property is on this page yet.',
  kindOf: (target: string) => `How ${target} is drawn`, usual: 'usual', min: (target: string) => `Least number of ${target}`, max: (target: string) => `Greatest number of ${target}`, up: (target: string) => `Move ${target} up`, down: (target: string) => `Move ${target} down`,
  remove: (target: string) => `Take ${target} off the page`, target: 'Property, such as robots/r1.location', add: 'Add',
  noStorage: 'A page is saved by a storage service, and none is there.', storage: 'Storage service', fileName: 'Name of the page', save: 'Save',
  badName: (name: string) => `“${name}” is no name for a page: letters, digits, - and _ are.`,
  savedAs: (target: string) => `It is saved as ${target}.`, saved: 'Pages that are saved',
  lastSet: 'Last SET', copy: 'Copy the command',
  widgets: {
    alarm: '▲ alarm', warn: '△ warning', bad: '✕ bad', uncertain: '? uncertain', stale: '◷ stale', gone: '⊘ gone', round: '↻ above',
    on: 'on', off: 'off', stop: 'Stop', stopOf: (name: string) => `Stop ${name}`, progressOf: (name: string) => `Progress of ${name}`,
    joystick: 'Joystick: arrow keys steer while they are held', within: (low: string, high: string, seconds: number) => `${low} … ${high} in ${seconds} s`,
    noPicture: (name: string) => `${name}: no picture yet`, picture: (name: string, width: number, height: number) => `${name}, ${width} by ${height}`,
    notPicture: (bytes: number) => `no picture: ${bytes} bytes`, numbers: (count: number, low: string, high: string) => `${count} numbers from ${low} to ${high}`,
    component: (name: string) => `Component of ${name}`, service: 'the service',
  },
  map: {
    set: 'Set', point: 'Point', region: 'Region', done: 'Done',
    pointHint: 'Click, or move the mark with the arrow keys (with Shift in larger steps) and press Enter. Escape ends.',
    regionHint: 'Click the corners, or move the mark with the arrow keys and press Enter at each; then Done. Escape ends.',
    at: (x: number, y: number) => `mark at ${x}, ${y}`, corners: (count: number) => `${count} corners`, sent: (name: string) => `${name} is set`,
    drawing: 'Map: arrow keys move the mark, Enter places it',
  },
};

export type PropertiesTexts = typeof propertiesTexts;
