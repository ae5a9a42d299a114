import type { ValuesTexts } from '../en/values';

export const valuesTexts: ValuesTexts = {
  title: '値', loading: '読み込み中…', none: '見始めてから値は届いていません。それより前の値は分かりません。', notKept: '値は保存されないため、その時の値は分かりません。', value: '最後の値', age: '経過', count: { in: '読み取り数', out: '書き込み数' },
  buffer: 'バッファ', waiting: (waiting, length) => `${length} 個中 ${waiting} 個`, dropped: '見始めてからの破棄数',
  plot: (port) => `${port} のグラフ (直近 60 秒)`, noNumbers: 'この値にはグラフにできる数値がありません。',
  last: '最近の値', time: '時刻', pause: 'グラフを止める', resume: '再開',
  record: '記録', recordTitle: (port) => `${port} を記録`, folder: 'フォルダ', file: 'ファイル名', replace: '既にあるファイルを置き換える', start: '開始',
  noFolder: '使えるフォルダがありません。「rtkit web --root FOLDER」で起動すると記録できます。', recording: (rows) => `記録中: ${rows}`, stop: '記録を止める', stopping: '停止しています…',
  recorded: (file) => `${file} に記録しました。`, recordFailed: (why) => `記録に失敗しました: ${why}`,
  inject: '値を書き込む…', injectTitle: (port) => `${port} に値を書き込む`, literal: '値 (JSON または YAML)', go: '書き込む', fits: '型に合います。', checking: '確認しています…',
  injected: (value, port) => `${port} に ${value} を書き込む`, unknown: (why) => `フィールドが分かりません: ${why}`, asking: '型をサーバーに問い合わせています…',
  open: (port) => `${port} の値`, cancel: '取り消し',
};
