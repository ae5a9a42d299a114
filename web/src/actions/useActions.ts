import { useCallback, useMemo, useRef, useState } from 'react';

import { ends as isEnding } from '../model/does';
import type { Action, Done } from '../model/types';
import { EMPTY_HISTORY, moved, recorded, type Entry, type History, type Way } from '../model/undo';
import { sentence, type Api } from '../server/api';
import { useTexts, type Texts } from '../texts';
import type { Toast, Toasts } from './useToasts';

/** A plan that waits for a yes or no. */
export interface Asked { label: string; plan: Done; ends: boolean; answer: (isYes: boolean) => void }

export interface Actions {
  asked: Asked | null;
  history: History;
  perform: (actions: Action[], label: string) => Promise<boolean>;
  /** Remembers what was done by other means than an action, and what takes it back. */
  remember: (entry: Entry) => void;
  move: (way: Way) => Promise<void>;
}

/** Does actions: shows the plan where there is more than one step, tells the result, remembers how to take it back. */
export function useActions(api: Api, toasts: Toasts): Actions {
  const texts = useTexts();
  const [asked, setAsked] = useState<Asked | null>(null);
  const [history, setHistory] = useState(EMPTY_HISTORY);
  const latest = useRef(history);
  /** Ends when all that was asked for is done. The picture may show it before: who then undoes means that action. */
  const running = useRef<Promise<unknown>>(Promise.resolve());
  const { add } = toasts;

  const change = useCallback((step: (history: History) => History) => {
    latest.current = step(latest.current);
    setHistory(latest.current);
  }, []);

  const confirmed = useCallback(async (actions: Action[], label: string): Promise<boolean> => {
    const plan = await api.act(actions, true);
    const ends = isEnding(actions);
    if (plan.steps.length < 2 && !ends) return true;
    return new Promise((resolve) => {
      const answer = (isYes: boolean) => {
        setAsked(null);
        resolve(isYes);
      };
      setAsked({ label, plan, ends, answer });
    });
  }, [api]);

  /** Null when the answer was no; throws what the server says. */
  const carryOut = useCallback(async (actions: Action[], label: string): Promise<Done | null> =>
    (await confirmed(actions, label)) ? api.act(actions, false) : null, [api, confirmed]);

  const tryOut = useCallback(async (actions: Action[], label: string): Promise<boolean> => {
    try {
      const done = await carryOut(actions, label);
      if (!done) return false;
      if (done.undo?.length) {
        const entry = { label, actions: done.undo };
        change((history) => recorded(history, entry));
      }
      add(toastOf(done, label, texts));
      return done.steps.every((step) => step.ok);
    } catch (error) {
      add({ level: 'error', title: texts.toast.failed(label), lines: [sentence(error)], command: '', canUndo: false });
      return false;
    }
  }, [add, carryOut, change, texts]);

  const perform = useCallback((actions: Action[], label: string): Promise<boolean> => {
    const done = tryOut(actions, label);
    running.current = Promise.all([running.current, done]);
    return done;
  }, [tryOut]);

  const remember = useCallback((entry: Entry) => change((history) => recorded(history, entry)), [change]);

  const drop = useCallback((way: Way, entry: Entry) => () =>
    change((history) => ({ ...history, [way]: history[way].filter((one) => one !== entry) })), [change]);

  const moveOne = useCallback(async (way: Way): Promise<void> => {
    const entry = latest.current[way].at(-1);
    if (!entry) {
      add({ level: 'info', title: way === 'undo' ? texts.toast.nothingToUndo : texts.toast.nothingToRedo, lines: [], command: '', canUndo: false });
      return;
    }
    const label = texts.label[way](entry.label);
    try {
      const done = await carryOut(entry.actions, label);
      if (!done) return;
      const inverse = done.undo?.length ? { label: entry.label, actions: done.undo } : null;
      const left = leftOf(entry, done);
      change((history) => moved(history, way, inverse, left));
      add({ ...toastOf(done, label, texts), canUndo: false, ...(left && { onDrop: drop(way, left) }) });
    } catch (error) {
      // Another value lives by now, or the thing has gone. Who brings it back can try again.
      const left = { ...entry, refusal: sentence(error) };
      change((history) => moved(history, way, null, left));
      add({ level: 'error', title: texts.toast.failed(label), lines: [left.refusal], command: '', canUndo: false, onDrop: drop(way, left) });
    }
  }, [add, carryOut, change, drop, texts]);

  const move = useCallback((way: Way): Promise<void> => {
    const moved = running.current.then(() => moveOne(way));
    running.current = moved;
    return moved;
  }, [moveOne]);

  return useMemo(() => ({ asked, history, perform, remember, move }), [asked, history, perform, remember, move]);
}

/** What of an entry was not done, with the reason; null when all was. Each action is one step. */
function leftOf(entry: Entry, done: Done): Entry | null {
  const failed = done.steps.findIndex((step) => step.ok === false);
  return failed < 0 ? null : { ...entry, actions: entry.actions.slice(failed), refusal: done.steps[failed]?.error ?? '' };
}

function toastOf(done: Done, label: string, texts: Texts): Omit<Toast, 'id'> {
  const failed = done.steps.filter((step) => step.ok === false);
  const ok = done.steps.filter((step) => step.ok);
  const command = ok.map((step) => step.command).filter(Boolean).join('\n');
  if (!failed.length) return { level: 'done', title: label, lines: [], command, canUndo: Boolean(done.undo?.length) };
  const partly = ok.length ? [texts.toast.partly(ok.length, done.steps.length)] : [];
  const lines = [...partly, ...failed.map((step) => step.error || step.text)];
  return { level: 'error', title: texts.toast.failed(label), lines, command, canUndo: false };
}
