import type { JobsTexts } from '../en/jobs';

export const jobsTexts: JobsTexts = {
  title: 'ジョブ', none: '実行中のコマンドも、終了したコマンドもありません。', which: 'ジョブ', status: '状態', rows: '行', runs: '実行中', done: '完了', stopped: '停止済み',
  failed: (status) => `失敗 (${status})`, stop: '停止', stopping: '停止しています…', noRows: 'まだ出力はありません。', all: 'すべてのジョブ',
  changes: '変更', noChange: 'サーバの起動後、変更はありません。', filter: '変更を絞り込む', when: '時刻', by: '変更元', what: '内容', was: '変更前', is: '変更後', thisPage: 'このページ',
  values: (n) => `${n} 個の値`, changeFailed: (why) => `失敗: ${why}`,
  earlier: (n) => `これより前の ${n} 行は表示していません。`,
};
