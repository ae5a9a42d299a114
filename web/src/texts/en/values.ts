/** Texts about the values of ports. */
export const valuesTexts = {
  title: 'Values', loading: 'Loading …', none: 'No value has come since you look; what came before is not known.', notKept: 'What it carried then is not known: values are not kept.', value: 'Last value', age: 'Age', count: { in: 'Values read', out: 'Values written' },
  buffer: 'Buffer', waiting: (waiting: number, length: number) => `${waiting} of ${length}`, dropped: 'Dropped since you look',
  plot: (port: string) => `Plot of ${port}, the last 60 s`, noNumbers: 'These values have no numbers to plot.',
  last: 'Last values', time: 'Time', pause: 'Hold the plot', resume: 'Go on',
  record: 'Record', recordTitle: (port: string) => `Record ${port}`, folder: 'Folder', file: 'File name', replace: 'Replace the file if it is there', start: 'Start',
  noFolder: 'No folder is granted: start with “rtkit web --root FOLDER” to record.', recording: (rows: string) => `Recording: ${rows}`, stop: 'Stop the recording', stopping: 'It is being stopped …',
  recorded: (file: string) => `Recorded in ${file}.`, recordFailed: (why: string) => `The recording failed: ${why}`,
  inject: 'Write a value …', injectTitle: (port: string) => `Write a value to ${port}`, literal: 'Value, as JSON or YAML', go: 'Write', fits: 'It fits.', checking: 'It is checked …',
  injected: (value: string, port: string) => `Write ${value} to ${port}`, unknown: (why: string) => `Its fields are not known: ${why}.`, asking: 'The server is asked for the type …',
  open: (port: string) => `Values of ${port}`, cancel: 'Cancel',
};

export type ValuesTexts = typeof valuesTexts;
