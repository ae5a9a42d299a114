import { badLine } from './connecting';
import type { Offers } from './types';

/** What is typed into the form that creates a component. `parameters` has a KEY=VALUE a line. */
export interface Creation { type: string; instance: string; slave: string; parameters: string }

/** The name to ask a manager for a type by: short where it is the only one of that name. */
export function typeKey(types: Offers['types'], type: Offers['types'][number]): string {
  return types.filter(({ name }) => name === type.name).length === 1 ? type.name : type.id;
}

/** The create string `TYPE?key=value&key=value`; null where a parameter is not KEY=VALUE. */
export function createString({ type, instance, slave, parameters }: Creation): string | null {
  if (badLine(parameters) !== null) return null;
  const rows = parameters.split('\n').map((line) => line.trim()).filter(Boolean)
    .map((line): [string, string] => [line.slice(0, line.indexOf('=')).trim(), line.slice(line.indexOf('=') + 1).trim()]);
  const options = [['instance_name', instance.trim()], ['manager_name', slave.trim()], ...rows].filter(([, value]) => value !== '');
  const text = options.map(([key, value]) => `${escaped(key ?? '')}=${escaped(value ?? '')}`).join('&');
  return text ? `${type}?${text}` : type;
}

/** These four have a meaning in create strings. */
const escaped = (text: string): string => text.replace(/[%&=?]/g, (sign) => `%${sign.charCodeAt(0).toString(16).toUpperCase()}`);
