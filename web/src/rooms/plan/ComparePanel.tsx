import { useEffect, useState } from 'react';

import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { MarkedPicture } from './MarkedPicture';
import type { Place } from './place';
import { CommandLine } from './StepTable';
import type { Comparison, Fact } from './types';
import type { PlanTexts } from './usePlanTexts';

const STATES = ['active', 'inactive', 'unknown'] as const;

interface Props { texts: PlanTexts; place: Place; files: readonly string[]; onGo: (to: Partial<Place>) => void }

/** Compares a profile with what lives now, or with another profile: an earlier one, say. */
export function ComparePanel({ texts, place, files, onGo }: Props) {
  const { api } = useEditor();
  const [state, setState] = useState<(typeof STATES)[number]>('active');
  const [found, setFound] = useState<Comparison | null>(null);
  const [problem, setProblem] = useState('');
  const [chosen, setChosen] = useState('');
  const [looks, setLooks] = useState(0);
  useEffect(() => {
    let isWanted = true;
    const asked = new URLSearchParams({ before: place.of, after: place.other, state });
    api.get<Comparison>(`/api/plans/compare?${asked}`).then(
      (comparison) => {
        if (!isWanted) return;
        setFound(comparison);
        setProblem('');
      },
      (error: unknown) => isWanted && setProblem(sentence(error)),
    );
    return () => {
      isWanted = false;
    };
  }, [api, place.of, place.other, state, looks]);
  return (
    <>
      <div className="row">
        <label>{texts.compareWith} <select value={place.other} onChange={(event) => onGo({ other: event.target.value })}>
          <option value="">{texts.live}</option>
          {files.filter((file) => file !== place.of).map((file) => <option key={file} value={file}>{file}</option>)}
        </select></label>
        {!place.other && (
          <label>{texts.compareState} <select value={state} onChange={(event) => setState(event.target.value as typeof state)}>
            {STATES.map((one) => <option key={one} value={one}>{texts.compareStates[one]}</option>)}
          </select></label>
        )}
        <button type="button" onClick={() => setLooks(looks + 1)}>{texts.compare}</button>
      </div>
      {problem ? <p className="error" role="alert">{problem}</p> : !found ? <p className="empty">{texts.loading}</p> : (
        <>
          <CommandLine texts={texts} command={found.command} />
          <p role="status">
            <span className={`step-state is-${found.same ? 'done' : 'failed'}`}><span aria-hidden="true">{found.same ? '✓' : '✕'}</span> {found.same ? texts.verdictSame : texts.verdictDiffers}</span>
            {' '}{found.facts.length ? texts.differs(found.facts.length) : texts.same}
          </p>
          <MarkedPicture texts={texts} picture={found.picture} chosen={chosen} onChoose={setChosen} />
          <ul className="facts">
            {found.facts.map((fact, index) => <FactRow key={index} texts={texts} fact={fact} isChosen={fact.subject !== '' && fact.subject === chosen} onChoose={setChosen} />)}
          </ul>
        </>
      )}
    </>
  );
}

function FactRow({ texts, fact, isChosen, onChoose }: { texts: PlanTexts; fact: Fact; isChosen: boolean; onChoose: (subject: string) => void }) {
  return (
    <li className={isChosen ? 'is-chosen' : ''}>
      <button type="button" className="link" aria-pressed={isChosen} onClick={() => onChoose(isChosen ? '' : fact.subject)}>
        <span className={`mark mark-${fact.mark === '+' ? 'added' : fact.mark === '-' ? 'removed' : 'changed'}`}>{fact.mark} {texts.marks[fact.mark]}</span>
        <span>{fact.text}
          {(fact.wanted || fact.found) && <code>{[fact.wanted && `${texts.wanted}: ${fact.wanted}`, fact.found && `${texts.found}: ${fact.found}`].filter(Boolean).join('  ')}</code>}
          {!fact.required && <em className="note"> {texts.optional}</em>}</span>
      </button>
    </li>
  );
}
