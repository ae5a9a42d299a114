/** What the dialog asks about a new connector. Empty texts are left to the server. */
export interface Wish {
  dataflow: string; subscription: string; policy: string; rate: string; skip: string; transport: string;
  source: BufferWish; target: BufferWish; further: string;
}

export interface BufferWish { length: string; full: string; empty: string }

const NO_BUFFER: BufferWish = { length: '', full: '', empty: '' };

export const NO_WISH: Wish = {
  dataflow: '', subscription: '', policy: '', rate: '', skip: '', transport: '', source: NO_BUFFER, target: NO_BUFFER, further: '',
};

/** Which fields make sense: a flush has no thread that a policy could rule, a pull has no writer that sends. */
export function meaningful({ dataflow, subscription, policy }: Wish) {
  const isPush = dataflow !== 'pull';
  const hasThread = isPush && subscription !== 'flush';
  return { subscription: isPush, policy: hasThread, rate: isPush && subscription === 'periodic', skip: hasThread && policy === 'skip' };
}

/** The properties of a connector as `rtcon -p` takes them. */
export function propertiesOf(wish: Wish): Record<string, string> {
  const fits = meaningful(wish);
  const rows: [string, string][] = [
    ['dataport.dataflow_type', wish.dataflow],
    ['dataport.interface_type', wish.transport],
    ['dataport.subscription_type', fits.subscription ? wish.subscription : ''],
    ['dataport.publisher.push_policy', fits.policy ? wish.policy : ''],
    ['dataport.publisher.push_rate', fits.rate ? wish.rate : ''],
    ['dataport.publisher.skip_count', fits.skip ? wish.skip : ''],
    ...bufferRows('dataport.outport.buffer', wish.source),
    ...bufferRows('dataport.inport.buffer', wish.target),
    ...lines(wish.further).map((line): [string, string] => [line.slice(0, line.indexOf('=')).trim(), line.slice(line.indexOf('=') + 1).trim()]),
  ];
  return Object.fromEntries(rows.filter(([, value]) => value !== ''));
}

/** What the dialog shows of a connector that states properties: the other way round. */
export function wishOf(properties: Readonly<Record<string, string>>): Wish {
  const rest = new Map(Object.entries(properties).filter(([key]) => key !== 'BEND_POINT'));
  const take = (key: string): string => {
    const value = rest.get(key) ?? '';
    rest.delete(key);
    return value;
  };
  const buffer = (prefix: string): BufferWish => ({ length: take(`${prefix}.length`), full: take(`${prefix}.write.full_policy`), empty: take(`${prefix}.read.empty_policy`) });
  const known = {
    dataflow: take('dataport.dataflow_type'), transport: take('dataport.interface_type'), subscription: take('dataport.subscription_type'),
    policy: take('dataport.publisher.push_policy'), rate: take('dataport.publisher.push_rate'), skip: take('dataport.publisher.skip_count'),
    source: buffer('dataport.outport.buffer'), target: buffer('dataport.inport.buffer'),
  };
  return { ...known, further: [...rest].map(([key, value]) => `${key}=${value}`).join('\n') };
}

const bufferRows = (prefix: string, { length, full, empty }: BufferWish): [string, string][] => [
  [`${prefix}.length`, length], [`${prefix}.write.full_policy`, full], [`${prefix}.read.empty_policy`, empty],
];

/** The first line that is not KEY=VALUE; null when all are. */
export const badLine = (further: string): string | null => lines(further).find((line) => line.indexOf('=') < 1) ?? null;

const lines = (text: string): string[] => text.split('\n').map((line) => line.trim()).filter(Boolean);
