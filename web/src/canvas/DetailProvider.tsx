import { useStore } from '@xyflow/react';
import { useMemo, type ReactNode } from 'react';

import { BoxDetailContext, WireDetailContext, type BoxDetail } from './DetailContext';

/** Below these zooms the names of ports, and then those of components, could not be read: leaving them out keeps 1,000 boxes quick. */
const DETAIL_ZOOM = 0.45;
const NAME_ZOOM = 0.2;
const LABEL_ZOOM = 0.5;
/** What a finger needs to hit a wire [px of the window]. */
const TARGET = 24;
/** Farther away wires are not picked by hand. */
const LEAST_ZOOM = 0.2;

interface Zoomed { transform: [number, number, number] }

const boxDetail = ({ transform: [, , zoom] }: Zoomed): BoxDetail => (zoom < NAME_ZOOM ? 'speck' : zoom < DETAIL_ZOOM ? 'name' : 'all');
const isLabelled = ({ transform: [, , zoom] }: Zoomed): boolean => zoom >= LABEL_ZOOM;
/** How wide the area of a wire is in the diagram, in steps: a new one costs a look at all wires. */
const areaOf = ({ transform: [, , zoom] }: Zoomed): number => TARGET / 2 ** (Math.floor(2 * Math.log2(Math.max(zoom, LEAST_ZOOM))) / 2);

/** Follows the zoom for all boxes and wires: React Flow asks each of its readers again in every frame while the picture moves. */
export function DetailProvider({ children }: { children: ReactNode }) {
  const box = useStore(boxDetail);
  const hasLabel = useStore(isLabelled);
  const area = useStore(areaOf);
  const wire = useMemo(() => ({ hasLabel, area }), [hasLabel, area]);
  return <BoxDetailContext value={box}><WireDetailContext value={wire}>{children}</WireDetailContext></BoxDetailContext>;
}
