import type { LogTexts } from '../en/log';

export const logTexts: LogTexts = {
  title: 'ログ', path: '対象', all: 'すべて', level: 'レベル', start: '開始', stop: '停止', stopping: '停止しています…', clear: '消去', save: '保存…', saveText: 'テキストで保存…', open: '開く…', close: '閉じる', opened: (file) => `${file} の記録です。`, bad: (n) => `${n} 行は記録ではありません。`,
  columns: { time: '時刻', level: 'レベル', manager: 'マネージャ', name: '名前', pid: 'PID', host: 'ホスト', message: 'メッセージ' },
  none: 'ログはまだありません。', noMatch: '条件に合う記録はありません。', idle: '開始すると、コンポーネントのログが表示されます。', of: (shown, all) => `${all} 件中 ${shown} 件`,
  earlier: (n) => `条件に合うそれ以前の ${n} 件は表示されませんが、保存されます。`, failed: (why) => `ログが終了しました: ${why}`,
  filter: '絞り込み', and: 'すべて満たす', or: 'いずれかを満たす', addTerm: '条件を追加', addGroup: 'グループを追加', remove: '条件を削除', removeGroup: 'グループを削除',
  field: '項目', fields: { any: 'すべての項目', message: 'メッセージ', level: 'レベル', name: '名前', manager: 'マネージャ', host: 'ホスト', pid: 'PID', source: '出所' },
  not: '否定', has: '含む', matches: '正規表現', how: '比較', text: '文字', badPattern: (pattern) => `「${pattern}」は正規表現ではありません。`,
  from: '開始時刻', to: '終了時刻', reset: 'すべて表示', follow: '最新に追従', inDiagram: (name) => `${name} を図に表示`,
};
