import { lazy, type ComponentType, type LazyExoticComponent } from 'react';

import type { System } from '../model/system';
import type { View } from './view';

export interface RoomProps { system: System; view: View }

type Part = LazyExoticComponent<ComponentType<RoomProps>>;

/** The rooms beside the diagram and its tables. Each is loaded when it is entered; its title is in the texts, under its kind. */
export const ROOMS = {
  plan: lazy(() => import('../rooms/plan/PlanRoom')),
  properties: lazy(() => import('../rooms/properties/PropertyRoom')),
  log: lazy(() => import('../rooms/log/LogRoom')),
  jobs: lazy(() => import('../rooms/jobs/JobsRoom')),
  document: lazy(() => import('../rooms/document/DocumentRoom')),
  machine: lazy(() => import('../rooms/machine/MachineRoom')),
  builder: lazy(() => import('../rooms/builder/BuilderRoom')),
} satisfies Record<string, Part>;

export type RoomKind = keyof typeof ROOMS;

export const ROOM_KINDS = Object.keys(ROOMS) as readonly RoomKind[];

/** Where Undo and Redo are about what lives; other rooms have a history of their own, or none. */
export const isAboutWhatLives = (kind: string): boolean => !isRoom(kind) || kind === 'properties';

export const isRoom = (kind: string): kind is RoomKind => Object.hasOwn(ROOMS, kind);
