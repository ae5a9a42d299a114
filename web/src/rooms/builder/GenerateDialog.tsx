import { useEffect, useMemo, useState } from 'react';

import { Modal } from '../../parts/Modal';
import { sentence } from '../../server/api';
import { useEditor } from '../../shell/contexts';
import { useTexts } from '../../texts';
import { commandOf, fateOf, writeFiles, type Choice, type FilePreview, type Written } from './calls';
import { Comparison } from './CodeView';
import { Fate } from './PreviewPane';
import { useBuilderTexts } from './fields';
import { textAt, type Form } from './form';

const CHOICES: readonly Choice[] = ['keep', 'merge', 'replace'];

/** The profile is what is edited here: it takes the place of that in the folder, unless somebody else has changed that meanwhile. */
const chosenByItself = (file: FilePreview, profile: string, isOutdated: boolean): Choice | undefined =>
  file.name === profile && isOutdated ? undefined : file.name === profile && file.fate !== 'written' ? 'replace' : fateOf(file) === 'kept' ? 'keep' : file.merged ? 'merge' : undefined;

interface Props { form: Form; folder: string; adds: boolean; profile: string; isOutdated: boolean; files: readonly FilePreview[]; onClose: () => void; onWritten: (written: Written, choices: Record<string, Choice>) => void }

/** Shows what becomes of each file, asks about those that the user has changed, and has rtbuild write them. */
export function GenerateDialog({ form, folder, adds, profile, isOutdated, files, onClose, onWritten }: Props) {
  const texts = useBuilderTexts();
  const cancel = useTexts().plan.cancel;
  const { api, canChange } = useEditor();
  const changed = files.filter((file) => file.before !== null && file.fate !== 'unchanged' && (file.fate !== 'written' || file.merged !== null));
  const asked = changed.filter((file) => file.name !== profile || isOutdated);
  const [choices, setChoices] = useState<Record<string, Choice | undefined>>(() => Object.fromEntries(changed.map((file) => [file.name, chosenByItself(file, profile, isOutdated)])));
  const [at, setAt] = useState(asked[0]?.name ?? '');
  const [problem, setProblem] = useState('');
  const [isBusy, setBusy] = useState(false);
  const shown = asked.find((file) => file.name === at);
  const undecided = asked.some((file) => (file.fate === 'conflict' || file.name === profile) && !choices[file.name]);
  const isNothing = files.every((file) => file.fate === 'unchanged' || (fateOf(file) === 'kept' && choices[file.name] === 'keep'));
  const decided = useMemo(() => Object.fromEntries(Object.entries(choices).flatMap(([name, choice]): [string, Choice][] => (choice ? [[name, choice]] : []))), [choices]);
  const [command, setCommand] = useState('');
  useEffect(() => {
    let isWanted = true;
    commandOf(api, form, folder, decided, adds).then((line) => isWanted && setCommand(line), (error: unknown) => isWanted && setProblem(sentence(error)));
    return () => {
      isWanted = false;
    };
  }, [api, form, folder, decided, adds]);
  const write = () => {
    setBusy(true);
    setProblem('');
    writeFiles(api, form, folder, decided, adds).then(
      (written) => {
        setBusy(false);
        if (written.ok) onWritten(written, decided);
        else setProblem(written.error);
      },
      (error: unknown) => {
        setBusy(false);
        setProblem(sentence(error));
      },
    );
  };
  return (
    <Modal title={texts.generate.title(textAt(form, 'basicInfo.name'))} className="generate" onClose={onClose}>
      <ul className="fates" aria-label={texts.generate.open}>
        {files.map((file) => <li key={file.name}><code>{file.name}</code><Fate file={file} />{file.why && <span className="note">{file.why}</span>}</li>)}
      </ul>
      {asked.length > 0 && (
        <section>
          <p>{texts.generate.decide}</p>
          <div className="group" role="group" aria-label={texts.generate.decide}>
            {asked.map((file) => <button key={file.name} type="button" aria-pressed={file === shown} onClick={() => setAt(file.name)}>{file.name}{choices[file.name] ? ' ✓' : ' ?'}</button>)}
          </div>
          {shown && (
            <>
              <fieldset className="choices" key={shown.name}>
                <legend className="unseen">{shown.name}</legend>
                {CHOICES.map((choice) => (
                  <label key={choice} className="check">
                    <input type="radio" name={`choice-${shown.name}`} disabled={choice === 'merge' && shown.merged === null} checked={choices[shown.name] === choice} onChange={() => setChoices({ ...choices, [shown.name]: choice })} />
                    {texts.generate.choices[choice]}
                  </label>
                ))}
                {shown.merged === null && <p className="note">{texts.generate.cannot}</p>}
              </fieldset>
              <Comparison file={shown.name} before={shown.before ?? ''} left={texts.preview.onDisk}
                after={choices[shown.name] === 'merge' ? (shown.merged ?? '') : shown.after} right={choices[shown.name] === 'merge' ? texts.preview.merged : texts.preview.generated} />
            </>
          )}
        </section>
      )}
      {isNothing && <p className="note">{texts.generate.nothing}</p>}
      {undecided && <p className="note warning">{texts.generate.undecided}</p>}
      {problem && <p className="error" role="alert">{problem}</p>}
      {command && <p><code>{command}</code></p>}
      <footer>
        <button type="button" onClick={onClose}>{cancel}</button>
        <button type="button" className="primary" disabled={!canChange || isBusy || undecided || isNothing} onClick={write}>{texts.generate.go}</button>
      </footer>
    </Modal>
  );
}
