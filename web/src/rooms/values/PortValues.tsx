import { useCallback, useState } from 'react';

import { plainText, pressureAt } from '../../model/flow';
import { endText } from '../../model/does';
import { portPath, type Connector, type Port, type PortEnd } from '../../model/types';
import { Icon } from '../../parts/icons';
import { age, clock } from '../../parts/numbers';
import { useNow } from '../../parts/useNow';
import { useSample } from '../../parts/useSample';
import { Fields } from '../../panels/Fields';
import { NO_VALUES, type Sample } from '../../server/values';
import { useEditor } from '../../shell/contexts';
import { InjectDialog } from './InjectDialog';
import { Plot } from './Plot';
import { Recorder } from './Recorder';
import { useValuesTexts } from './useValuesTexts';
import './values.css';

const ROWS = 8;

interface Props { end: PortEnd; direction: Port['direction']; wire?: Connector }

/** What a port, or a wire from it, carries: last value, plot of a minute, the last values; record it, or write to it. */
export default function PortValues({ end, direction, wire }: Props) {
  const texts = useValuesTexts();
  const { values, canChange } = useEditor();
  const [held, setHeld] = useState<readonly Sample[] | null>(null);
  const [isInjecting, setInjecting] = useState(false);
  const path = portPath(end);
  const sample = useSample(path);
  const target = wire ? portPath(wire.target) : direction === 'in' ? path : '';
  const pressures = usePressures(target, wire);
  const now = useNow();
  const samples = useCallback(() => values.kept(path), [values, path]);
  const hasNumbers = Object.keys(sample?.numbers ?? {}).length > 0;
  return (
    <div className="port-values">
      <Fields rows={[
        [texts.value, sample?.text !== undefined && <code key="value" className="value">{plainText(sample)}</code>],
        [texts.age, sample?.at ? age(sample.at, now) : ''],
        [direction === 'in' && !wire ? texts.count.in : texts.count.out, sample?.count ?? ''],
        [texts.buffer, pressures.map(({ waiting, length }) => texts.waiting(waiting, length)).join(', ')],
        [texts.dropped, pressures.some(({ dropped }) => dropped) ? pressures.map(({ dropped }) => dropped).join(', ') : ''],
      ].filter(([, value]) => value !== false) as [string, string][]} />
      {sample?.text === undefined && <p className="empty">{values === NO_VALUES ? texts.notKept : texts.none}</p>}
      {sample?.text !== undefined && !hasNumbers && <p className="empty">{texts.noNumbers}</p>}
      {hasNumbers && <Plot label={texts.plot(endText(end))} samples={samples} isHeld={held !== null} />}
      <div className="buttons">
        {hasNumbers && (
          <button type="button" aria-pressed={held !== null} onClick={() => setHeld(held ? null : samples())}><Icon name={held ? 'play' : 'pause'} />{held ? texts.resume : texts.pause}</button>
        )}
        {direction === 'in' && !wire && <button type="button" disabled={!canChange} onClick={() => setInjecting(true)}>{texts.inject}</button>}
      </div>
      {direction === 'out' && <Recorder port={path} />}
      <LastValues samples={held ?? samples()} />
      {isInjecting && <InjectDialog port={path} onClose={() => setInjecting(false)} />}
    </div>
  );
}

/** The buffer of a wire, or of all wires at an in port. */
function usePressures(target: string, wire: Connector | undefined) {
  const sample = useSample(target);
  const ids = wire ? [wire.id] : Object.keys(sample?.buffers ?? {});
  return ids.flatMap((id) => pressureAt(sample, id) ?? []);
}

function LastValues({ samples }: { samples: readonly Sample[] }) {
  const texts = useValuesTexts();
  const shown = samples.slice(-ROWS).reverse();
  if (!shown.length) return null;
  return (
    <table className="last-values">
      <caption>{texts.last}</caption>
      <thead><tr><th scope="col">{texts.time}</th><th scope="col">{texts.value}</th></tr></thead>
      <tbody>{shown.map((one) => <tr key={`${one.at ?? 0} ${one.count}`}><td className="time">{clock(one.at ?? 0, true)}</td><td>{plainText(one)}</td></tr>)}</tbody>
    </table>
  );
}
