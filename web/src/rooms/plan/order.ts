/** One step of an order of a profile, as its text is edited: see `rtprofile order --help`. */
export interface OrderStep { name: string; at: string; wait: string; after: string[]; timeout: string; isSent: boolean }

export const newStep = (name: string): OrderStep => ({ name, at: '', wait: '', after: [], timeout: '', isSent: false });

export function stepOf(text: string): OrderStep {
  const at = text.indexOf(':');
  const step = newStep(at < 0 ? text : text.slice(0, at));
  for (const part of at < 0 ? [] : text.slice(at + 1).split(',')) {
    const [key = '', ...rest] = part.split('=');
    const value = rest.join('=');
    if (key === 'after') step.after = [...step.after, value];
    else if (key === 'at' || key === 'wait' || key === 'timeout') step[key] = value;
    else if (key === 'sent') step.isSent = true;
  }
  return step;
}

/** The text of a step; what makes no sense together is left out. */
export function stepText({ name, at, wait, after, timeout, isSent }: OrderStep): string {
  const parts = [
    ...(at ? [`at=${at}`] : []),
    ...(after.length ? [...after.map((one) => `after=${one}`), ...(timeout ? [`timeout=${timeout}`] : []), ...(isSent ? ['sent'] : [])] : wait ? [`wait=${wait}`] : []),
  ];
  return parts.length ? `${name}:${parts.join(',')}` : name;
}

/** The steps with one moved to another place. */
export function moved<T>(steps: readonly T[], from: number, to: number): T[] {
  const rest = steps.filter((_, index) => index !== from);
  const step = steps[from];
  return step === undefined || to < 0 || to >= steps.length ? [...steps] : [...rest.slice(0, to), step, ...rest.slice(to)];
}
