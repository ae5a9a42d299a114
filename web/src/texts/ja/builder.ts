import type { BuilderTexts } from '../en/builder';

/** コンポーネントを作る画面の文言。 */
export const builderTexts: BuilderTexts = {
  title: 'コンポーネントを作る',
  pages: {
    basic: '基本', activity: 'アクティビティ', data: 'データポート', services: 'サービスポート', parameters: 'コンフィグレーション',
    machine: '状態機械', documentation: 'ドキュメント', language: '言語・環境', source: 'RTC.xml',
  },
  pagesLabel: 'プロファイルの各部',
  start: {
    lead: 'コンポーネントをフォームで記述します。コードは入力中に表示され、指示したときにフォルダーへ書き込まれます。',
    name: '新しいコンポーネントの名前', go: '始める', known: 'プロファイルを開く', none: '許可されたフォルダーに RTC プロファイルはありません。',
    noFolder: '許可されたフォルダーがありません。ファイルを書くには「rtkit web --root フォルダー」で起動してください。フォーム、プレビュー、書き出しはそのまま使えます。',
    upload: 'ファイルを読む…', tooLarge: 'プロファイルは 4 MiB までです。', back: '下書きに戻る',
  },
  bar: {
    files: '開く…', undo: '元に戻す', redo: 'やり直す', folder: 'フォルダー', export: '書き出し', generate: '生成…', tryIt: '試す…',
    changed: '変更あり', errors: (n) => `エラー ${n} 件`, warnings: (n) => `注意 ${n} 件`,
    good: '指摘はありません', reopen: '下書きには、まだ生成していない変更があります。',
    discard: '下書きを破棄', discarded: 'まだ生成していない変更は失われます。下書きを破棄しますか?',
    adds: '既存のパッケージに追加', addsHint: 'フォルダーにあるコンポーネントと同じパッケージに入れます',
  },
  outdated: {
    title: '開いた後にディスク上のプロファイルが変更されました。', compare: '比較', merge: '両方をまとめる', take: 'ディスクの内容を取り込む', ignore: '自分の内容を保つ',
    conflicts: '両方で変更されています。自分の内容を保ちました:',
  },
  backups: {
    open: 'バックアップ…', title: 'バックアップ', hint: '置き換えたファイルは NAME.bak として 10 世代まで残ります。戻すと、今のファイルは最新のバックアップになります。', none: 'このフォルダーにバックアップはありません。',
    putBack: '戻す', clear: (n: number) => `バックアップ ${n} 件をすべて削除`, ask: '元に戻せません。', close: '閉じる',
  },
  preview: {
    title: 'ファイル', code: 'コード', difference: '差分', whole: '全体', stale: '生成しています…', none: 'エラーを直すとファイルが表示されます。',
    fates: { written: '書き込み', unchanged: '変更なし', kept: 'あなたの変更を保持', conflict: '競合' }, fresh: '新規',
    old: 'エラーの前の内容です。',
    lines: (added, removed) => `+${added} −${removed}`, skipped: (n) => `同じ行 ${n} 行`,
    same: 'ディスク上のファイルと同じです。', own: 'あなたのコード: 保持されます。', notes: '注意', list: '生成されるファイル',
    onDisk: 'ディスク上', generated: '生成', merged: 'マージ', number: '行', gone: '削除', came: '追加',
  },
  generate: {
    title: (name) => `${name} を生成`, nothing: '変わるファイルはありません。', decide: '次のファイルは印の外側が変更されています。それぞれ選んでください。',
    choices: { keep: '自分のものを残す', replace: '生成されたものにする (自分のものは NAME.bak)', merge: '両方をマージする (自分のものは NAME.bak)' },
    cannot: 'マージできません。同じ行が変更されているか、元の生成物が分かりません。',
    go: '生成', done: (n) => `${n} 個のファイルを書き込みました。`, open: '各ファイルの扱い',
    undecided: '競合しているファイルごとに選んでください。',
  },
  tryIt: {
    title: (name) => `${name} をマネージャで試す`, manager: 'マネージャ', none: '動作中のマネージャがありません。「rtmgr start」で起動してください。',
    instance: 'コンポーネントの名前', slave: 'スレーブ (なければ作成)', slaveHint: 'マネージャ自身',
    warning: 'フォルダー内のコードが、あなたの権限で実行されます。', go: '読み込んで作成', waiting: (id) => `${id} を待っています…`,
    first: '先に生成してください。フォルダー内のファイルがフォームと異なります。', label: (name) => `${name} を試す`,
    asking: 'マネージャに問い合わせています…',
  },
  source: {
    hint: 'プロファイルをテキストで編集します。取り込む前に、現在のものと並べて表示します。',
    look: '比較', take: '取り込む', back: '破棄', comparison: 'フォームとの差分', text: 'プロファイルのテキスト', equal: 'フォームと同じ内容です。',
    present: 'フォーム', wished: 'テキスト',
  },
  list: {
    up: (name) => `${name} を上へ`, down: (name) => `${name} を下へ`, remove: (name) => `${name} を削除`, unnamed: '(名前なし)', more: '詳細', document: 'ドキュメント',
    addIn: '入力ポートを追加', addOut: '出力ポートを追加', addService: 'サービスポートを追加', addInterface: 'インターフェースを追加', addParameter: 'パラメータを追加',
    addTarget: '環境を追加', addLibrary: 'ライブラリを追加', addTransition: '遷移を追加', addLog: '項目を追加', addMachine: '状態機械を追加',
    noPorts: 'ポートはまだありません。', noServices: 'サービスポートはまだありません。', noParameters: 'パラメータはまだありません。',
    machineHint: 'イベントポートが状態機械のイベントを運びます。フォルダーに NAMEFSM.scxml の図があれば、この表より優先されます。',
    complex: 'この制約は RTC.xml で編集します。', onlyPython: 'rtbuild が生成するのは Python です。他の言語はプロファイルに残ります。',
    targets: '環境', libraries: 'ライブラリ', logs: '変更履歴', transitions: '遷移', interfaces: 'インターフェース',
  },
  fields: {
    name: '名前', description: '説明', version: 'バージョン', vendor: 'ベンダー', category: 'カテゴリ', componentType: 'コンポーネント型', activityType: 'アクティビティ型',
    componentKind: '種類', maxInstances: '最大インスタンス数', executionType: '実行コンテキスト', executionRate: '実行周期 [Hz]', abstract: '概要', rtcType: 'RTC タイプ',
    hardwareProfile: 'ハードウェア', portType: '方向', type: '型', variableName: '変数名', position: '位置', unit: '単位', idlFile: 'IDL ファイル', interfaceType: 'インターフェース型',
    dataflowType: 'データフロー', subscriptionType: 'サブスクリプション', constraint: '制約', comment: 'コメント', defaultValue: '既定値', widget: 'ウィジェット', step: '刻み',
    direction: '方向', instanceName: 'インスタンス', path: 'パス', number: '数', semantics: '意味', occurrence: '周期', operation: '頻度',
    preCondition: '事前条件', postCondition: '事後条件', inout: '入出力', algorithm: 'アルゴリズム', creator: '作成者', license: 'ライセンス', reference: '参考文献',
    ifdescription: 'インターフェース', docArgument: '引数', docReturn: '戻り値', docException: '例外', docPreCondition: '事前条件', docPostCondition: '事後条件',
    kind: '言語', langVersion: '言語のバージョン', os: 'OS', osVersions: 'OS のバージョン', cpus: 'CPU', other: 'その他', cpuOther: 'その他の CPU',
    source: '遷移元', target: '遷移先', condition: '条件', initial: '最初の状態', dataname: 'データ名', range: '範囲', event: 'イベント', log: '項目',
  },
  words: { DataInPort: '入力', DataOutPort: '出力', LEFT: '左', RIGHT: '右', TOP: '上', BOTTOM: '下', Provided: '提供', Required: '要求' },
};
