import { Suspense, lazy } from 'react';

import type { Connector, Port, PortEnd } from '../model/types';
import { useTexts } from '../texts';

const PortValues = lazy(() => import('../rooms/values/PortValues'));

/** The values of a port; what draws them is loaded when somebody looks. */
export function LazyValues(props: { end: PortEnd; direction: Port['direction']; wire?: Connector }) {
  const texts = useTexts();
  return <Suspense fallback={<p className="empty">{texts.bar.roomLoading}</p>}><PortValues {...props} /></Suspense>;
}
