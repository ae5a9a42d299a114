import { useEffect, useState } from 'react';

import type { Files } from '../../model/types';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import type { RoomProps } from '../../shell/rooms';
import { ComparePanel } from './ComparePanel';
import { DoPanel } from './DoPanel';
import { FileList } from './FileList';
import { JobPanel } from './JobPanel';
import { OrderPanel } from './OrderPanel';
import { placeOf, textOf, type Place } from './place';
import './plan.css';
import { usePlanTexts } from './usePlanTexts';

const TABS = ['do', 'compare', 'order'] as const;

/** Plans: what is to become of a system, shown first, then done; systems compared; orders of profiles. */
export default function PlanRoom({ system, view }: RoomProps) {
  const texts = usePlanTexts();
  const { api, show } = useEditor();
  const [known, setKnown] = useState<Files | null>(null);
  const [problem, setProblem] = useState('');
  const [looks, setLooks] = useState(0);
  const place = placeOf(view.of);
  const go = (to: Partial<Place>) => show('plan', textOf({ ...place, other: '', ...to }));
  useEffect(() => {
    let isWanted = true;
    api.files().then((files) => isWanted && setKnown(files), (error: unknown) => isWanted && setProblem(sentence(error)));
    return () => {
      isWanted = false;
    };
  }, [api, looks]);
  const job = place.tab === 'job' ? system.jobs.get(place.of) : undefined;
  const isThere = known !== null && (place.of === '' || known.files.includes(place.of));
  return (
    <main className="room plans" aria-labelledby="plans-title">
      <FileList texts={texts} known={known} jobs={[...system.jobs.values()].filter((one) => one.kind === 'plan')} place={place} onGo={go} onSaved={() => setLooks((n) => n + 1)} />
      <div className="plans-main">
        <header className="row">
          <h2 id="plans-title">{place.tab === 'job' ? (job?.text ?? texts.title) : place.of || texts.live}</h2>
          {place.tab !== 'job' && (
            <div className="group" role="group" aria-label={texts.title}>
              {TABS.map((tab) => <button key={tab} type="button" aria-pressed={place.tab === tab} onClick={() => go({ tab })}>{texts.tabs[tab]}</button>)}
            </div>
          )}
        </header>
        {problem && <p className="error" role="alert">{problem}</p>}
        {place.tab === 'job' ? (job ? <JobPanel key={job.id} texts={texts} system={system} job={job} onGo={go} /> : <p className="empty">{system.isKnown ? texts.noJob : texts.loading}</p>)
          : !isThere ? <p className="empty">{known ? texts.noFile(place.of) : texts.loading}</p>
          : place.tab === 'do' ? <DoPanel key={place.of} texts={texts} file={place.of} system={system} onGo={go} />
          : !place.of ? <p className="empty">{texts.liveOnly}</p>
          : place.tab === 'compare' ? <ComparePanel key={view.of} texts={texts} place={place} files={known.files} onGo={go} />
          : <OrderPanel key={place.of} texts={texts} file={place.of} />}
      </div>
    </main>
  );
}
