import type { Change, Component, Connector, Picture, Port } from '../src/model/types';

/** Records for tests: whole, with what the test is about put over. */
export function component(name: string, more: Partial<Component> = {}): Component {
  return {
    id: `/localhost/${name}.rtc`, name, type: name.replace(/\d+$/, ''), type_id: '', manager: '/localhost/manager.mgr', process: '/localhost/manager.mgr',
    state: 'Inactive', look: 'inactive', word: 'Inactive', remark: '', since: 0, description: '', composite: '', members: [], is_composite: false, contexts: [], ports: [],
    active_set: 'default', sets: { default: {} }, widgets: {}, constraints: {}, properties: {}, ...more,
  };
}

export const port = (name: string, direction: Port['direction'], type = 'TimedLong'): Port => ({ name, direction, type, interfaces: [] });

export function wire(id: string, source: string, target: string): Connector {
  const end = (text: string) => ({ component: `/localhost/${text.split('.')[0] ?? ''}.rtc`, port: text.split('.')[1] ?? '' });
  return { id, name: id, source: end(source), target: end(target), properties: {}, trouble: '' };
}

export function picture(more: Partial<Picture> = {}): Picture {
  return { revision: 1, since: 0, host: 'robot', version: '1', read_only: false, managers: [{ id: '/localhost/manager.mgr', name: 'manager', host: 'localhost', pid: 1, version: '1', state: 'up', why: '', rights: null }], processes: [], components: [], connectors: [], jobs: [], ...more };
}

export function change(revision: number, more: Partial<Change> = {}): Change {
  return { revision, time: 0, managers: [], processes: [], components: [], connectors: [], events: [], gone: { managers: [], processes: [], components: [], connectors: [] }, ...more };
}

export const NOTHING_GONE = { managers: [], processes: [], components: [], connectors: [] };
