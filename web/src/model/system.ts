import type { Change, Component, Connector, Job, JobNews, Manager, Picture, Process, Rates, TreeEvent } from './types';

/** The picture of the running system: the server's events folded, nothing else. */
export interface System {
  revision: number;
  host: string;
  version: string;
  isReadOnly: boolean;
  /** The first moment that the server knows [s since 1970]. */
  since: number;
  managers: ReadonlyMap<string, Manager>;
  processes: ReadonlyMap<string, Process>;
  components: ReadonlyMap<string, Component>;
  connectors: ReadonlyMap<string, Connector>;
  events: readonly TreeEvent[];
  rates: Rates;
  jobs: ReadonlyMap<string, Job>;
  /** Grows when boxes or wires appear, vanish or get other ports: only then a new layout is needed. */
  structure: number;
  /** False until the first picture has come. */
  isKnown: boolean;
}

export type SystemEvent =
  | { kind: 'picture'; picture: Picture }
  | { kind: 'change'; change: Change }
  | { kind: 'rates'; rates: Rates }
  | { kind: 'job'; news: JobNews }
  | { kind: 'past'; since: number }
  | { kind: 'events'; events: TreeEvent[] };

/** So many events are kept for the strip; the server keeps the rest. */
export const EVENTS_KEPT = 1000;

const NO_RATES: Rates = { connectors: {}, components: {} };

export const EMPTY_SYSTEM: System = {
  revision: 0, host: '', version: '', isReadOnly: false, since: 0,
  managers: new Map(), processes: new Map(), components: new Map(), connectors: new Map(),
  events: [], rates: NO_RATES, jobs: new Map(), structure: 0, isKnown: false,
};

export function reduceSystem(system: System, event: SystemEvent): System {
  switch (event.kind) {
    case 'picture':
      return fromPicture(system, event.picture);
    case 'change':
      return changed(system, event.change);
    case 'rates':
      return { ...system, rates: event.rates };
    case 'job':
      return { ...system, jobs: new Map([...system.jobs, [event.news.id, jobOf(event.news)]]) };
    case 'past':
      return { ...system, since: event.since };
    case 'events':
      return { ...system, events: [...event.events, ...newer(system.events, event.events)].slice(-EVENTS_KEPT) };
  }
}

/** Events of the stream that came while the earlier ones were asked for. */
function newer(events: readonly TreeEvent[], earlier: readonly TreeEvent[]): TreeEvent[] {
  const last = earlier.at(-1)?.time ?? -Infinity;
  return events.filter((event) => event.time > last);
}

function fromPicture(system: System, picture: Picture): System {
  return {
    revision: picture.revision, host: picture.host, version: picture.version, isReadOnly: picture.read_only, since: picture.since,
    managers: byId(picture.managers), processes: byId(picture.processes),
    components: byId(picture.components), connectors: byId(picture.connectors),
    events: system.events, rates: NO_RATES, jobs: byId(picture.jobs), structure: system.structure + 1, isKnown: true,
  };
}

/** The job without its rows: those go to who listens. */
const jobOf = ({ id, kind, text, command, status, error, count }: JobNews): Job => ({ id, kind, text, command, status, error, count });

function changed(system: System, change: Change): System {
  // A change at or below the picture's revision is already part of it.
  if (change.revision <= system.revision) return system;
  return {
    ...system,
    revision: change.revision,
    managers: merged(system.managers, change.managers, change.gone.managers),
    processes: merged(system.processes, change.processes, change.gone.processes),
    components: merged(system.components, change.components, change.gone.components),
    connectors: merged(system.connectors, change.connectors, change.gone.connectors),
    events: change.events.length ? [...system.events, ...change.events].slice(-EVENTS_KEPT) : system.events,
    structure: system.structure + (changesStructure(system, change) ? 1 : 0),
  };
}

function changesStructure(system: System, change: Change): boolean {
  const { gone } = change;
  return (
    gone.managers.length + gone.processes.length + gone.components.length + gone.connectors.length > 0 ||
    change.managers.some((manager) => !system.managers.has(manager.id)) ||
    change.processes.some((process) => !system.processes.has(process.id)) ||
    change.connectors.some((connector) => !system.connectors.has(connector.id)) ||
    change.components.some((component) => shape(component) !== shape(system.components.get(component.id)))
  );
}

/** What of a component decides its box: its place and its ports, not its state. */
function shape(component: Component | undefined): string {
  if (!component) return '';
  const ports = component.ports.map((port) => `${port.direction} ${port.name}`);
  return [component.process, component.composite, component.type, ...component.members, ...ports].join('\n');
}

function byId<T extends { id: string }>(records: T[]): Map<string, T> {
  return new Map(records.map((record) => [record.id, record]));
}

function merged<T extends { id: string }>(before: ReadonlyMap<string, T>, news: T[], gone: string[]): ReadonlyMap<string, T> {
  if (!news.length && !gone.length) return before;
  const after = new Map(before);
  for (const id of gone) after.delete(id);
  for (const record of news) after.set(record.id, record);
  return after;
}
