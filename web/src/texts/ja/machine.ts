import type { MachineTexts } from '../en/machine';

export const machineTexts: MachineTexts = {
  title: '状態機械', none: '状態機械のサービスがありません。ここで作成するか、「rtmgr -c StateMachine」を実行してください。', asking: 'サービスに問い合わせています…',
  name: '状態機械', state: 'アクティブな状態', run: '実行', refresh: '更新', draw: '新しい状態機械', all: 'すべての状態機械',
  runs: { stopped: '停止', running: '実行中', paused: '一時停止', done: '終了' },
  connecting: '状態機械に問い合わせています…', gone: (why) => `応答がありません: ${why}`, newTitle: '新しい状態機械',
  views: '状態機械の表示', chart: '状態図', outline: '一覧', chartLabel: '状態図', empty: '状態がまだありません。「状態」ボタンか N キーで追加してください。',
  minimap: '状態機械の全体図',
  active: 'アクティブ', initial: '初期', final: '終了', composite: '内部に状態あり', plain: '状態',
  nodeLabel: (path, words) => (words ? `${path}、${words}` : path),
  wayLabel: (from, to, text) => `${from} から ${to || '移動なし'} への遷移: ${text}`,
  newWay: (name) => `${name} から別の状態への遷移を描く`, release: '状態の上で離すと、そこへの遷移になります。',
  signs: { '+': '追加', '−': '削除', '~': '変更' },

  controls: '実行', start: '開始', pause: '一時停止', step: 'ステップ', stop: '停止', resume: '再開',
  event: 'イベント', send: '送信', waits: '待っているイベント', sendOf: (name) => `イベント ${name} を送信`,
  last: '最後の遷移', atTime: (time) => time, withData: (data) => `原因: ${data}`,

  edit: '編集', addState: '状態', addInside: '内部の状態', addFinal: '終了状態', addWay: '遷移', remove: '削除', undo: '元に戻す', redo: 'やり直す',
  apply: '適用…', create: '作成…', discard: '破棄', files: '開く・保存…',
  changes: (n) => `未適用の変更が ${n} 件あります。`,
  stale: '他の利用者が状態機械を編集しました。このままでは適用できません。',
  keep: '自分の編集で上書きする', takeTheirs: '相手の編集を採用する',
  problems: '問題', problemOf: (state, text) => (state ? `${state}: ${text}` : text), whole: '問題はありません。', odd: '注意',

  inspector: 'インスペクター', machine: '状態機械', stateOf: (path) => `状態 ${path}`, wayOf: (path) => `${path} の遷移`,
  nothing: '状態か遷移を選ぶと、ここで編集できます。',
  fields: {
    name: '名前', doc: '説明', outer: '親の状態', outermost: 'なし (最も外側)', initial: '初期状態', isInitial: '最初に入る', isFinal: '終了状態 (外側はここで終わる)',
    entry: '入るとき', exit: '出るとき', do: 'アクティブな間くり返す', transitions: '遷移 (この順に試す)', variables: '変数',
    to: '遷移先', stays: 'なし (状態は変わらない)', on: 'イベント', when: '条件', after: '経過時間 [s]', actions: '遷移時の動作',
    onHint: 'なし、* はすべて', whenHint: 'robots/r1.x > 1 and light.on', first: '初期値', value: '値', now: '現在', variable: '変数',
  },
  nameFaults: { bad: '名前には英数字と - _ を使い、英字で始めてください。', taken: '同じ名前の状態があります。' },
  actionKinds: { set: 'プロパティを SET', assign: '変数を設定', raise: 'イベントを発生' },
  hows: { value: '値', expression: '計算式', get: '取得元' },
  target: '対象', kind: '動作', how: '方法', every: '周期 [s]', addAction: '動作', addVariable: '変数',
  removeOf: (what) => `${what} を削除`, upOf: (what) => `${what} を先に試す`, downOf: (what) => `${what} を後で試す`, setOf: (name) => `変数 ${name} を今設定する`, set: '設定',
  atOnce: '直ちに', open: '開く',

  table: { state: '状態', kind: '種類', actions: '動作', transitions: '遷移', edit: '編集' },

  log: '履歴', logAll: 'すべて', logTransitions: '遷移', time: '時刻', what: '種類', text: '内容', noLog: 'まだ何も起きていません。',
  kinds: {
    run: '実行', value: '値', event: 'イベント', time: '時間', transition: '遷移', set: 'SET', assign: '変数', failed: '失敗', edited: '編集', lost: '消失',
  },

  diff: {
    title: (name) => `${name} に編集を適用`, lead: 'すべてが 2 つのステップの間に有効になるか、何も変わりません。', machine: '状態機械',
    gotoLead: (state) => `アクティブな状態 ${state} がなくなります。`, goto: 'どの状態に移りますか', choose: '状態を選択', wrong: 'まだ適用できません:',
    go: '適用', cancel: 'キャンセル', none: '変更はありません。', reformatted: 'テキスト中のコメントと書式は保持されません。',
    parts: {
      initial: '初期状態', final: '終了状態', doc: '説明', entry: '入るとき', exit: '出るとき', do: 'くり返し', variables: '変数', name: '名前', order: '順序', atOnce: '直ちに',
    },
  },
  creating: {
    title: '状態機械を作成', service: 'サービスの名前', manager: 'マネージャ', instance: 'コンポーネントの名前', go: '作成', noManager: 'マネージャが動いていません。「rtmgr start」で開始してください。',
    wrong: '先に状態機械の問題を直してください。',
  },
  saving: {
    title: '状態機械のファイル', what: '保存する範囲と開く場所', whole: '状態機械全体', part: (path) => `状態 ${path} とその内部 (開くものはその内部に入る)`, download: '描いたものを保存', forms: { turtle: 'RDF (Turtle)', xml: 'RDF/XML', scxml: 'SCXML' }, upload: 'ファイルを開く', browse: 'ファイルを選択…',
    from: 'ストレージまたはフォルダーから', source: 'ストレージのプロパティまたはファイル', fetch: '開く', to: '動作中の状態機械を保存', target: 'ストレージのプロパティまたはフォルダー内のファイル',
    save: '保存', replace: 'ファイルがあれば置き換える', noFolder: '使えるフォルダーがありません。「rtkit web --root FOLDER」で開始すると、状態機械を開いたり保存したりできます。',
    notApplied: '未適用の変更は保存されません。', close: '閉じる',
  },
  label: {
    edit: (name) => `${name} を編集`, run: (name, word) => `${name}: ${word}`, event: (name, event) => `${name} に ${event} を送信`,
    variable: (name, variable) => `${name} の ${variable} を設定`, save: (name, file) => `${name} を ${file} に保存`, create: (name) => `状態機械 ${name} を作成`,
  },
  connectTitle: (name) => `${name} からの遷移を描く`, connectGo: '描く',
  keys: 'キー: 矢印で状態を移動、Enter で編集、N で状態を追加、Shift+N で内部に追加、C で遷移、Delete で削除、Ctrl+Z で元に戻す。',
};
