import type { Texts } from '../en';
import { manageTexts } from './manage';

/** Japanese texts, in the words of OpenRTM's Japanese manuals where they have one. */
export const ja: Texts = {
  key: 'ja',
  language: '日本語',
  looks: {
    active: 'アクティブ', inactive: '非アクティブ', error: 'エラー', created: '生成済み', unknown: '不明',
    zombie: 'ゾンビ', stuck: '応答停止', unreachable: '到達不能', restarting: '再起動中',
  },
  managerStates: { up: '稼働中', gone: '消失' },
  processStates: { up: '稼働中', starting: '起動中', stopped: '停止', silent: '無応答', lost: '消失' },
  directions: { in: '入力', out: '出力', service: 'サービス' },
  contextKinds: { PERIODIC: '周期実行', EVENT_DRIVEN: 'イベント駆動', OTHER: 'その他' },

  link: {
    connecting: 'サーバーに接続しています…',
    lost: (since) => `サーバーとの接続がありません。表示は ${since} の時点のものです。自動的に再接続します。`,
    managerGone: (names) => `サーバーから見えなくなったマネージャ: ${names}。表示は最後に分かっていた状態です。`,
    readOnly: '読み取り専用',
    readOnlyHint: 'サーバーは --read-only で起動されています。ここからは何も変更できません。',
  },
  rights: {
    roles: { administrator: '管理者 (administrator)', operator: '操作者 (operator)', viewer: '閲覧者 (viewer)', component: 'コンポーネント (component)' },
    at: (role, host) => `${host}: ${role}`,
    mayLook: (name, role, host) => `${name} は ${host} では ${role} で、見ることだけができます。変更には operator、作成と終了には administrator のロールが必要です。`,
    mayNotMake: (name, role, host) => `${name} は ${host} では ${role} で、今あるものを変更できます。作成と終了には administrator のロールが必要です。`,
  },
  locked: {
    refused: 'サーバーがこのトークンを拒否しました。トークンは「rtkit web」を起動するたびに変わります。',
    title: 'このページにはトークンが必要です',
    body: '「rtkit web」が表示するアドレスを開くか、ここに貼り付けてください。',
    field: 'アドレスまたはトークン',
    open: '開く',
  },

  bar: {
    search: '検索または実行…', views: '表示', rooms: { plan: '計画', document: 'オフライン', properties: 'プロパティ', log: 'ログ', jobs: 'ジョブ', machine: '状態機械', builder: 'ビルダー' }, plansFor: '保存、適用、復元、比較', roomLoading: '読み込み中…', diagram: '図', table: '表',
    undo: '元に戻す', redo: 'やり直す', arrange: '整列', fit: '全体表示', zoomIn: '拡大', zoomOut: '縮小',
    help: 'キー', theme: '配色', themes: { auto: '自動', light: 'ライト', dark: 'ダーク' },
    languageLabel: '言語', tree: 'ツリー', inspector: 'インスペクタ', events: 'イベント',
    undoOf: (label) => `元に戻す: ${label}`, redoOf: (label) => `やり直す: ${label}`, refused: (label, why) => `${label} (拒否: ${why})`,
    show: (panel) => `${panel}を表示`, hide: (panel) => `${panel}を隠す`,
  },

  canvas: {
    label: 'コンポーネントとコネクタの図',
    empty: '動作中のコンポーネントはありません。「rtmgr start」でマネージャを起動するか、「rtapply」でシステムを読み込んでください。',
    emptyManager: '動作中のコンポーネントはありません。マネージャを選択してコンポーネントを作成するか、「計画」でシステムを起動してください。',
    loading: '描画しています…',
    fold: (name) => `${name} を折りたたむ`, unfold: (name) => `${name} を展開する`,
    
    kinds: { manager: 'マネージャ', process: 'スレーブ', composite: '複合コンポーネント', component: 'コンポーネント' },
    component: (name, type, state, ports) => `${name}、${type}、${state}、ポート ${ports} 個`,
    wire: (source, target) => `${source} から ${target} へのコネクタ`,
    components: (n) => `コンポーネント ${n} 個`,
    release: '光っているポートの上で離すと接続します。',
    asking: '接続できるポートをサーバーに問い合わせています…',
    noneFits: 'このポートに接続できるポートはありません。',
    minimap: '全体図',
  },

  tree: {
    title: 'ツリー', filter: '文字で絞り込む', filterState: '状態で絞り込む', all: 'すべての状態',
    troubled: '問題あり', none: '条件に合うものはありません。', 
  },

  inspector: {
    title: 'インスペクタ', overview: '概要', state: '状態', since: '開始', type: '型', process: 'プロセス', manager: 'マネージャ',
    host: 'ホスト', pid: 'プロセス ID', version: 'バージョン', path: 'パス', composite: '所属', members: '構成要素', description: '説明',
    actions: '操作', contexts: '実行コンテキスト', rate: '周期', hz: 'Hz', running: '動作中', stopped: '停止中', set: '設定',
    ports: 'ポート', connectors: 'コネクタ', noPorts: 'このコンポーネントにポートはありません。', free: '未接続',
    configuration: 'コンフィギュレーション', setName: 'コンフィギュレーションセット', activeSet: 'アクティブ', activateSet: 'このセットをアクティブにする',
    noParameters: 'このセットにパラメータはありません。', apply: '適用', revert: '破棄', changed: '変更あり',
    
    values: '値', valuesOf: (port) => `${port} の値`, properties: 'プロパティ', noProperties: 'プロパティはありません。', source: '接続元', target: '接続先', trouble: '問題', written: '書き込み数',
    several: (n) => `${n} 個を選択中`, countByState: '状態別のコンポーネント数', managers: 'マネージャ', hidden: '隠しセットを表示',
    nothing: 'コンポーネント、コネクタ、マネージャを選択すると、ここに表示されます。', 
    connect: '接続…',
  },
  misfit: {
    notANumber: '数値ではありません。', mustSatisfy: (rule) => `値は ${rule} を満たす必要があります。`,
    notOffered: (value) => `「${value}」は選択肢にありません。`,
  },
  list: { up: (item) => `${item} を上へ`, down: (item) => `${item} を下へ` },

  act: {
    activate: 'アクティブ化', deactivate: '非アクティブ化', reset: 'リセット', end: '終了', forget: '登録を消す',
    connect: '接続', disconnect: '切断', 
  },
  label: {
    activate: (name) => `${name} をアクティブ化`, deactivate: (name) => `${name} を非アクティブ化`,
    reset: (name) => `${name} をリセット`, end: (name) => `${name} を終了`,
    connect: (source, target) => `${source} と ${target} を接続`,
    disconnect: (source, target) => `${source} と ${target} を切断`,
    disconnectSome: (n) => `コネクタ ${n} 本を切断`,
    configure: (name) => `${name} を設定`, activateSet: (name, set) => `${name} のセット ${set} をアクティブ化`,
    save: (file) => `システムを ${file} に保存`,
    create: (name, manager) => `${manager} に ${name} を生成`, load: (module, manager) => `${manager} に ${module} をロード`,
    set: (target) => `${target} を設定`,
    rate: (name, hz) => `${name} の周期を ${hz} Hz に設定`,
    several: (n) => `コンポーネント ${n} 個`, undo: (label) => `元に戻す: ${label}`, redo: (label) => `やり直す: ${label}`,
  },

  plan: {
    title: '計画', lead: (n) => (n === 1 ? '次のことを行います:' : `次の ${n} 個の手順を順に行います:`),
    ends: 'コンポーネントが終了します。元に戻せません。', noUndo: (why) => `元に戻せません: ${why}`,
    go: '実行', cancel: '取り消し', 
  },
  toast: {
    region: '結果', copy: 'コマンドとしてコピー', copied: 'コピーしました', close: '閉じる', undo: '元に戻す',
    failed: (label) => `${label}: 失敗しました。`,
    partly: (done, all) => `${all} 個の手順のうち ${done} 個を行いました。`,
    drop: '履歴から外す',
    nothingToUndo: '元に戻すものはありません。', nothingToRedo: 'やり直すものはありません。',
  },

  connect: {
    title: '接続', from: '接続元のポート', to: '接続先のポート', filter: 'ポートを絞り込む', name: 'コネクタの名前',
    nameHint: '空ならサーバーが決めます。', buffers: 'バッファ', none: '接続できるポートはありません。',
    unfit: (n) => `接続できないポート (${n})`, byDefault: '既定', asking: '接続できるポートをサーバーに問い合わせています…',
    dataflow: 'データフロー', subscription: 'サブスクリプション', policy: 'プッシュポリシー', rate: 'プッシュ周期 [Hz]', skip: 'スキップ数',
    transport: '転送方式', atSource: '出力ポート側', atTarget: '入力ポート側', length: '長さ', full: '満杯のとき', empty: '空のとき',
    further: 'その他のプロパティ (1 行に KEY=VALUE を 1 つ)', badLine: (line) => `「${line}」は KEY=VALUE の形ではありません。`,
    pushPolicies: { new: 'new: 最新の値', all: 'all: 溜まった値すべて', fifo: 'fifo: 1 つずつ順に', skip: 'skip: n 個ごと' },
    subscriptions: { new: 'new: スレッドが送る', flush: 'flush: 書き込み呼び出しの中で送る', periodic: 'periodic: 一定周期で送る' },
    dataflows: { push: 'push: 書き手が送る', pull: 'pull: 読み手が取りに行く' },
  },

  create: {
    open: 'コンポーネントを生成…', title: (manager) => `${manager} にコンポーネントを生成`, filter: '型を絞り込む', go: '生成',
    asking: '生成できる型をマネージャに問い合わせています…', noType: '条件に合う型はありません。',
    instance: 'インスタンス名', instanceHint: '空ならマネージャが決めます。',
    slave: 'スレーブ', slaveHint: '空ならマネージャ自身。', parameters: 'パラメータ (1 行に KEY=VALUE を 1 つ)',
  },
  load: {
    open: 'モジュールをロード…', title: (manager) => `${manager} にモジュールをロード`, path: 'モジュールのファイル', go: 'ロード',
    init: '初期化関数', initHint: '空なら通常のもの。',
    found: (n) => (n === 0 ? '未ロードのモジュールは見つかりません。' : `未ロードのモジュールが ${n} 個あります。`),
  },
  exporting: {
    open: 'エクスポート…', title: 'システムの図を保存', print: '印刷…', printHint: '表示中のもの', asOf: (time) => `${time} の時点のシステムです。`, forms: { png: 'PNG', svg: 'SVG', dot: 'dot', mermaid: 'Mermaid', text: 'テキスト' },
    hints: { png: '点の画像、スライドやメール用', svg: '画像', dot: 'Graphviz 用', mermaid: 'Markdown 用', text: '80 桁幅' },
  },

  palette: {
    title: '検索または実行', placeholder: 'コンポーネント、ポート、型、操作', none: '該当するものはありません。',
    kinds: { action: '操作', component: 'コンポーネント', port: 'ポート', type: '型', manager: 'マネージャ' },
    hint: 'Enter で移動または実行、Escape で閉じます。',
  },
  events: {
    title: 'イベント', filter: 'イベントを絞り込む', pause: '一時停止', resume: '再開', time: '時刻', path: 'パス', event: 'イベント', detail: '詳細',
    none: 'まだ何も起きていません。', waiting: (n) => `ほか ${n} 件`,
  },
  past: {
    line: '時間軸: 矢印キーで変化ごとに移動', now: '現在', at: (time, changes) => `${time} (変化 ${changes} 件の後)`,
    asItWas: (time) => `${time} の時点の状態です。ここでは何も変更できません。その時に流れた値は分かりません。`, loading: '過去を読み込んでいます…',
  },
  table: {
    label: 'コンポーネント、ポート、コネクタの表', components: 'コンポーネント', ports: 'ポート', connectors: 'コネクタ', filter: '表を絞り込む',
    name: '名前', type: '型', state: '状態', remark: '備考', process: 'プロセス', actions: '操作', component: 'コンポーネント', port: 'ポート',
    direction: '方向', connected: '接続相手', source: '接続元', target: '接続先', rate: '頻度', trouble: '問題',
    noRows: '表示するものはありません。', more: (n) => `ほか ${n} 行。絞り込むと表示されます。`,
  },
  keys: {
    title: 'キー', close: '閉じる',
    rows: [
      ['Tab', '次のコンポーネントへ移る'], ['矢印キー', 'その方向のコンポーネントへ移る。何も選択していなければ表示を動かす'],
      ['Shift + 矢印キー', 'その方向のコンポーネントを選択に加える'], ['Ctrl + A', 'すべてのコンポーネントを選択する'],
      ['Alt + 矢印キー', '選択したコンポーネントを動かす'], ['Enter', 'インスペクタを開く'], ['Escape', '選択を解除する'],
      ['C', '選択したコンポーネントのポートを接続する'], ['Delete', '選択したものを切断または終了する'],
      ['Ctrl + Z', '最後の操作を元に戻す'], ['Ctrl + Shift + Z', 'やり直す'], ['Ctrl + K  または  /', 'コンポーネント、ポート、型、操作を探す'],
      ['F', '全体を表示する'], ['+  −', '拡大・縮小する'], ['T', '図と表を切り替える'], ['?', 'このキー一覧を表示する'],
    ],
  },
  manage: manageTexts,
  live: {
    became: (name, state) => `${name}: ${state}`, more: (n) => `ほか ${n} 件`, gone: (name) => `${name} がなくなりました`,
  },
};
