import { useEffect, useId, useState } from 'react';

import { Modal } from '../../parts/Modal';
import { download } from '../../parts/download';
import { sentence } from '../../server/api';
import type { MachineAction } from '../../model/types';
import { useEditor } from '../../shell/contexts';
import { added, nameOf } from './draft';
import { ChoiceField, TextField } from './fields';
import type { MachineRecord, Places } from './types';
import { useMachineTexts } from './useMachine';

const ENDINGS = { turtle: 'ttl', xml: 'rdf', scxml: 'scxml' } as const;
type Form = keyof typeof ENDINGS;

interface Props {
  machine: MachineRecord;
  /** The service that lives; empty of a machine that is drawn only. */
  service: string;
  isChanged: boolean;
  /** The state that is selected: it may be saved, or another one opened inside it. */
  selected: string;
  onOpen: (machine: MachineRecord) => void; onClose: () => void;
}

/** Files: what is drawn is saved by the browser, what lives by its service; both are opened into the draft. */
export function MachineFiles({ machine, service, isChanged, selected, onOpen, onClose }: Props) {
  const texts = useMachineTexts();
  const words = texts.saving;
  const { api, perform, canWrite } = useEditor();
  const [problem, setProblem] = useState('');
  const [places, setPlaces] = useState<Places | null>(null);
  const [source, setSource] = useState('');
  const [target, setTarget] = useState('');
  const [isReplaced, setReplaced] = useState(false);
  const [part, setPart] = useState('');
  const id = useId();
  useEffect(() => {
    api.get<Places>('/api/machine/places').then(setPlaces, (error: unknown) => setProblem(sentence(error)));
  }, [api]);
  const attempt = async (work: () => Promise<void>) => {
    setProblem('');
    try {
      await work();
    } catch (error) {
      setProblem(sentence(error));
    }
  };
  const written = async (form: Form) => (await api.post<{ text: string }>('/api/machine/write', { machine, form, at: part })).text;
  const save = (form: Form) => attempt(async () => {
    download(new Blob([await written(form)], { type: form === 'turtle' ? 'text/turtle' : 'application/xml' }), `${part ? nameOf(part) : machine.name}.${ENDINGS[form]}`);
  });
  const take = async (text: string) => {
    const at = part && added(machine, part, 'part')[1];
    onOpen((await api.post<{ machine: MachineRecord }>('/api/machine/read', { text, at, ...(at && { machine }) })).machine);
    onClose();
  };
  const upload = (file: File | undefined) => file && attempt(async () => take(await file.text()));
  const fetchIt = () => attempt(async () => {
    const query = source.startsWith('/') && places?.files.includes(source) ? `file=${encodeURIComponent(source)}` : `target=${encodeURIComponent(source)}`;
    await take((await api.get<{ text: string }>(`/api/machine/stored?${query}`)).text);
  });
  const isFile = places?.folders.some((folder) => target.startsWith(`${folder}/`)) ?? false;
  const keep = () => attempt(async () => {
    const action: MachineAction = isFile ? { do: 'save_machine', machine: service, file: target, replace: isReplaced, at: part }
      : part ? { do: 'store_state', target, text: await written('turtle') } : { do: 'keep_machine', machine: service, target };
    if (await perform([action], texts.label.save(service, target))) onClose();
  });
  return (
    <Modal title={words.title} className="machine-files" onClose={onClose}>
      {selected && <ChoiceField label={words.what} value={part} choices={[['', words.whole], [selected, words.part(selected)]]} onChange={setPart} />}
      <h3>{words.download}</h3>
      <div className="buttons">{(Object.keys(ENDINGS) as Form[]).map((form) => <button key={form} type="button" disabled={form === 'scxml' && part !== ''} onClick={() => void save(form)}>{words.forms[form]}</button>)}</div>
      <h3>{words.upload}</h3>
      <label className="field"><span className="unseen">{words.browse}</span><input type="file" accept=".ttl,.rdf,.xml,.scxml" onChange={(event) => void upload(event.target.files?.[0])} /></label>
      <h3>{words.from}</h3>
      <form className="row" onSubmit={(event) => { event.preventDefault(); if (source) void fetchIt(); }}>
        <TextField isHidden label={words.source} placeholder="files.machines.night.ttl" value={source} list={`${id}-sources`} onChange={setSource} />
        <button type="submit" disabled={!source}>{words.fetch}</button>
      </form>
      <datalist id={`${id}-sources`}>{[...(places?.stored ?? []), ...(places?.files ?? [])].map((one) => <option key={one} value={one} />)}</datalist>
      {service && (
        <>
          <h3>{words.to}</h3>
          {isChanged && <p className="warning">{words.notApplied}</p>}
          <form className="row" onSubmit={(event) => { event.preventDefault(); if (target) void keep(); }}>
            <TextField isHidden label={words.target} placeholder="files.machines.new.ttl" value={target} list={`${id}-targets`} isDisabled={!canWrite} onChange={setTarget} />
            <button type="submit" disabled={!target || !canWrite}>{words.save}</button>
          </form>
          <datalist id={`${id}-targets`}>{[...(places?.stored ?? []), ...(places?.folders.map((folder) => `${folder}/${machine.name}.ttl`) ?? [])].map((one) => <option key={one} value={one} />)}</datalist>
          {isFile && <label className="check"><input type="checkbox" checked={isReplaced} onChange={(event) => setReplaced(event.target.checked)} />{words.replace}</label>}
        </>
      )}
      {places && places.folders.length === 0 && <p className="note">{words.noFolder}</p>}
      {problem && <p className="error" role="alert">{problem}</p>}
      <footer><button type="button" onClick={onClose}>{words.close}</button></footer>
    </Modal>
  );
}
