/** Texts of the room of jobs. */
export const jobsTexts = {
  title: 'Jobs', none: 'No command is at work, and none has been.', which: 'Job', status: 'Status', rows: 'Rows', runs: 'runs', done: 'done', stopped: 'stopped',
  failed: (status: number) => `failed (${status})`, stop: 'Stop', stopping: 'It is being stopped …', noRows: 'It has told nothing yet.', all: 'All jobs',
  earlier: (n: number) => `${n} earlier rows are not shown.`,
};

export type JobsTexts = typeof jobsTexts;
