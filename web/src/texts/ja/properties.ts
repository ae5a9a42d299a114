import type { PropertiesTexts } from '../en/properties';

export const propertiesTexts: PropertiesTexts = {
  heading: 'プロパティ', tree: 'サービスとコンポーネントのプロパティ', search: 'プロパティを検索', nothingFound: 'その名前のものはありません。',
  choose: 'サービス、コンポーネント、またはそのプロパティを選んでください。', asking: '問い合わせ中…',
  silent: (why) => `表示は古い可能性があります: ${why}`,
  ownPage: 'マイページ', addToOwn: 'マイページに追加', edit: '編集', title: 'タイトル', noItems: 'このページにはまだプロパティがありません。',
  kindOf: (target) => `${target} の表示方法`, usual: '標準', min: (target) => `${target} の最小値`, max: (target) => `${target} の最大値`, up: (target) => `${target} を上へ`, down: (target) => `${target} を下へ`,
  remove: (target) => `${target} をページから外す`, target: 'プロパティ (例: robots/r1.location)', add: '追加',
  noStorage: 'ページの保存にはストレージサービスが必要ですが、見つかりません。', storage: 'ストレージサービス', fileName: 'ページの名前', save: '保存',
  badName: (name) => `「${name}」はページの名前に使えません。英数字、-、_ を使ってください。`,
  savedAs: (target) => `${target} として保存しました。`, saved: '保存されたページ',
  lastSet: '最後の SET', copy: 'コマンドをコピー',
  widgets: {
    alarm: '▲ 警報', warn: '△ 注意', bad: '✕ 不良', uncertain: '? 不確か', stale: '◷ 古い', gone: '⊘ なし', round: '↻ 上にあり',
    on: 'オン', off: 'オフ', stop: '停止', stopOf: (name) => `${name} を停止`, progressOf: (name) => `${name} の進み具合`,
    joystick: 'ジョイスティック: 矢印キーを押している間だけ動きます', within: (low, high, seconds) => `${low} … ${high} (${seconds} 秒間)`,
    noPicture: (name) => `${name}: まだ画像がありません`, picture: (name, width, height) => `${name}、${width} × ${height}`,
    notPicture: (bytes) => `画像ではありません: ${bytes} バイト`, numbers: (count, low, high) => `${count} 個の数値、${low} から ${high}`,
    component: (name) => `${name} のコンポーネント`, service: 'サービス',
  },
  map: {
    set: '設定先', point: '点', region: '領域', done: '完了',
    pointHint: 'クリックするか、矢印キー (Shift で大きく) で印を動かして Enter を押します。Escape で終わります。',
    regionHint: '角をクリックするか、矢印キーで印を動かして角ごとに Enter を押し、「完了」を押します。Escape で終わります。',
    at: (x, y) => `印の位置 ${x}, ${y}`, corners: (count) => `角 ${count} 個`, sent: (name) => `${name} を設定しました`,
    drawing: '地図: 矢印キーで印を動かし、Enter で置きます',
  },
};
