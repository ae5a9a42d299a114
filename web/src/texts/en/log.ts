/** Texts of the room of logs. */
export const logTexts = {
  title: 'Log', path: 'Of', all: 'everything', level: 'Down to level', start: 'Start', stop: 'Stop', stopping: 'It is being stopped …', clear: 'Clear', save: 'Save …', saveText: 'Save as text …', open: 'Open …', close: 'Close it', opened: (file: string) => `Records of ${file}.`, bad: (n: number) => (n === 1 ? 'One line is no record.' : `${n} lines are no records.`),
  columns: { time: 'Time', level: 'Level', manager: 'Manager', name: 'Name', pid: 'PID', host: 'Host', message: 'Message' },
  none: 'Nothing has been logged.', noMatch: 'No record matches the filter.', idle: 'Start to see what components log.', of: (shown: number, all: number) => `${shown} of ${all} records`,
  earlier: (n: number) => `${n} earlier records that match are not shown; they are saved.`, failed: (why: string) => `The log ended: ${why}`,
  filter: 'Filter', and: 'All of these', or: 'One of these', addTerm: 'Add a condition', addGroup: 'Add a group', remove: 'Remove the condition', removeGroup: 'Remove the group',
  field: 'Field', fields: { any: 'anything', message: 'message', level: 'level', name: 'name', manager: 'manager', host: 'host', pid: 'PID', source: 'source' },
  not: 'not', has: 'has', matches: 'matches', how: 'Comparison', text: 'Text', badPattern: (pattern: string) => `“${pattern}” is no regular expression.`,
  from: 'From', to: 'To', reset: 'Show all', follow: 'Follow the newest', inDiagram: (name: string) => `Show ${name} in the diagram`,
};

export type LogTexts = typeof logTexts;
