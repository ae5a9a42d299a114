/** Texts of the room of jobs. */
export const jobsTexts = {
  title: 'Jobs', none: 'No command is at work, and none has been.', which: 'Job', status: 'Status', rows: 'Rows', runs: 'runs', done: 'done', stopped: 'stopped',
  failed: (status: number) => `failed (${status})`, stop: 'Stop', stopping: 'It is being stopped …', noRows: 'It has told nothing yet.', all: 'All jobs',
  changes: 'Changes', noChange: 'Nothing has been changed since the server began.', filter: 'Filter the changes', when: 'When', by: 'By', what: 'What', was: 'Before', is: 'Since', thisPage: 'this page',
  values: (n: number) => `${n} values`, changeFailed: (why: string) => `failed: ${why}`,
  earlier: (n: number) => `${n} earlier rows are not shown.`,
};

export type JobsTexts = typeof jobsTexts;
