import { managersAt } from '../../model/rights';
import { RightsGate } from '../../panels/RightsGate';
import type { RoomProps } from '../../shell/rooms';
import './machine.css';
import { MachineEditor } from './MachineEditor';
import { NEW, Overview } from './Overview';

/** State machines: those that live, one of them, or a new one. */
export default function MachineRoom({ system, view }: RoomProps) {
  if (!view.of) return <Overview />;
  const service = view.of === NEW ? '' : view.of;
  return <RightsGate system={system} ids={managersAt(system, service)}><MachineEditor key={service} service={service} system={system} /></RightsGate>;
}
