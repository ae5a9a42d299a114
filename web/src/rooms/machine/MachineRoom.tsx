import type { RoomProps } from '../../shell/rooms';
import './machine.css';
import { MachineEditor } from './MachineEditor';
import { NEW, Overview } from './Overview';

/** State machines: those that live, one of them, or a new one. */
export default function MachineRoom({ system, view }: RoomProps) {
  if (!view.of) return <Overview />;
  const service = view.of === NEW ? '' : view.of;
  return <MachineEditor key={service} service={service} system={system} />;
}
