const KEY = 'rtkit.token';
const CHANNEL = 'rtkit.token';

/** So long a new tab waits for another tab's token. */
const ASK_MS = 400;

/**
 * Returns the token of this session: from the address, from this tab, or from another tab that has it. Empty if none has.
 *
 * It never goes into a cookie, which all ports of a host would share, nor stays in the address, which people copy.
 */
export async function findToken(): Promise<string> {
  const token = fromAddress() || sessionStorage.getItem(KEY) || (await fromOtherTab());
  if (token) keepToken(token);
  return token;
}

export function keepToken(token: string): void {
  sessionStorage.setItem(KEY, token);
}

export function dropToken(): void {
  sessionStorage.removeItem(KEY);
}

/** Answers tabs that ask for the token, until the returned function is called. */
export function shareToken(): () => void {
  const channel = new BroadcastChannel(CHANNEL);
  channel.onmessage = (message: MessageEvent<{ ask?: boolean }>) => {
    const token = sessionStorage.getItem(KEY);
    if (message.data.ask && token) channel.postMessage({ token });
  };
  return () => channel.close();
}

/** Takes the token out of the address and cleans the address. */
export function fromAddress(): string {
  const fields = new URLSearchParams(location.hash.slice(1));
  const token = fields.get('token') ?? '';
  if (!token) return '';
  fields.delete('token');
  const rest = fields.toString();
  history.replaceState(null, '', location.pathname + location.search + (rest ? `#${rest}` : ''));
  return token;
}

function fromOtherTab(): Promise<string> {
  return new Promise((resolve) => {
    const channel = new BroadcastChannel(CHANNEL);
    const finish = (token: string) => {
      clearTimeout(timer);
      channel.close();
      resolve(token);
    };
    const timer = setTimeout(() => finish(''), ASK_MS);
    channel.onmessage = (message: MessageEvent<{ token?: string }>) => {
      if (message.data.token) finish(message.data.token);
    };
    channel.postMessage({ ask: true });
  });
}
