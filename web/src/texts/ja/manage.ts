import type { ManageTexts } from '../en/manage';

export const manageTexts: ManageTexts = {
  sets: {
    copy: '複製 …', rename: '名前の変更 …', remove: '削除', title: { copy: 'コンフィグレーションセットの追加', rename: 'コンフィグレーションセットの名前の変更' },
    name: 'セットの名前', like: (set) => `${set} と同じ内容です。`, which: '含まれるパラメータ', taken: 'この名前のセットはすでにあります。',
    activeStays: 'アクティブなセットは名前の変更も削除もできません。', hiddenStays: '隠しセットは作者のものです。表示だけできます。', go: '実行',
  },
  contexts: {
    drives: '他に駆動するもの', attach: 'アタッチ', detach: (name) => `${name} をデタッチ`, choose: 'アタッチするコンポーネント', owner: '所有者',
    missed: (n) => `${n} 回の周期が抜けました。`, without: (trouble) => `次の設定なしで動作しています: ${trouble}`,
  },
  composites: {
    make: '複合コンポーネントの作成 …', title: '複合コンポーネントの作成', name: '複合コンポーネントの名前', type: '型', rate: '実行コンテキストの周期 [Hz]', ports: '公開するポート',
    types: {
      PeriodicECSharedComposite: '一つのコンテキストがすべてのメンバーを駆動', PeriodicStateSharedComposite: '一つのコンテキストで、状態もそろって変わる',
      GroupingComposite: 'それぞれが自分のコンテキストを保つ',
    },
    onePlace: '複合コンポーネントのメンバーは一つのプロセスにある必要があります。', dissolve: '解除', inside: '中を見る', members: 'メンバー', letGo: (name) => `${name} を外す`,
    takeIn: 'コンポーネントを入れる', shown: (port) => `${port} を公開`, none: '中に何もありません。',
  },
  managers: {
    start: 'マネージャの起動 …', title: 'マネージャの起動', name: '名前', nameHint: '空: 通常のもの。', host: 'ホスト', hostHint: '空: このホスト。',
    fork: 'スレーブを起動', restart: '再起動', stop: '停止', shutDown: 'シャットダウン', stopHint: '次の起動ですべてが元に戻ります。',
    shutDownHint: '持っていたものをすべて忘れます。', endSlave: 'スレーブを終了', modules: 'ロード済みのモジュール', forget: (module) => `${module} をアンロード`,
    noModules: 'ロード済みのモジュールはありません。', forgetZombies: (n) => `ゾンビ ${n} 個を削除`,
  },
  label: {
    addSet: (name, set) => `${name} にセット ${set} を追加`, renameSet: (name, set, to) => `${name} のセット ${set} を ${to} に変更`,
    removeSet: (name, set) => `${name} のセット ${set} を削除`, attach: (guest, name) => `${guest} を ${name} にアタッチ`,
    detach: (guest, name) => `${guest} を ${name} からデタッチ`, compose: (name) => `${name} を作成`, dissolve: (name) => `${name} を解除`,
    takeIn: (member, name) => `${member} を ${name} に入れる`, letGo: (member, name) => `${member} を ${name} から外す`,
    show: (port, name) => `${name} で ${port} を公開`, hide: (port, name) => `${name} で ${port} を非公開`,
    start: (name) => `${name} を起動`, restart: (name) => `${name} を再起動`, stop: (name) => `${name} を停止`,
    shutDown: (name) => `${name} をシャットダウン`, fork: (name) => `${name} のスレーブを起動`, endSlave: (name) => `${name} を終了`,
    unload: (module, name) => `${name} で ${module} をアンロード`,
  },
  wires: {
    all: 'すべて切断', between: (n) => `これらのポートの間に ${n} 本のコネクタがあります`, pairs: 'インターフェース', pairsHint: '同じ型のインターフェースが対になります。',
    noPairs: '一方のインターフェースを他方は使いません。',
  },
  scope: {
    more: 'その他の絞り込み', kind: '種類で絞り込む', kinds: { all: 'すべての種類', manager: 'マネージャ', slave: 'スレーブ', composite: '複合コンポーネント', component: 'コンポーネント' },
    host: 'ホストで絞り込む', allHosts: 'すべてのホスト', manager: 'マネージャで絞り込む', allManagers: 'すべてのマネージャ', type: '型で絞り込む', allTypes: 'すべての型',
    near: '接続されたものだけ', steps: '段数', nearOf: (name, steps) => `${name} から ${steps} 段以内`,
    insideOf: (name) => `${name} の中`, shows: (n, all) => `${all} 個中 ${n} 個のコンポーネントを表示`, all: 'すべて表示', path: '現在の場所', system: 'システム',
  },
  keptEnds: 'マネージャが再び起動されるまでコンポーネントは終了します。',
};
