import { meaningful, type BufferWish, type Wish } from '../model/connecting';
import { useTexts } from '../texts';

interface Props { wish: Wish; onChange: (wish: Wish) => void; wrongLine: string | null }

/** How values travel: what makes no sense together is greyed. What is left alone, the server decides. */
export function ConnectorOptions({ wish, onChange, wrongLine }: Props) {
  const texts = useTexts();
  const words = texts.connect;
  const fits = meaningful(wish);
  const set = (part: Partial<Wish>) => onChange({ ...wish, ...part });
  return (
    <>
      <div className="grid">
        <Choice label={words.subscription} value={wish.subscription} options={words.subscriptions} isDisabled={!fits.subscription} onChange={(subscription) => set({ subscription })} />
        <Choice label={words.policy} value={wish.policy} options={words.pushPolicies} isDisabled={!fits.policy} onChange={(policy) => set({ policy })} />
        <Amount label={words.rate} value={wish.rate} isDisabled={!fits.rate} onChange={(rate) => set({ rate })} />
        <Amount label={words.skip} value={wish.skip} isDisabled={!fits.skip} onChange={(skip) => set({ skip })} />
        <Choice label={words.dataflow} value={wish.dataflow} options={words.dataflows} onChange={(dataflow) => set({ dataflow })} />
        <Choice label={words.transport} value={wish.transport} options={same('zenoh', 'direct', 'shm')} onChange={(transport) => set({ transport })} />
      </div>
      <details>
        <summary>{words.buffers}</summary>
        <Buffer title={words.atSource} wish={wish.source} onChange={(source) => set({ source })} />
        <Buffer title={words.atTarget} wish={wish.target} onChange={(target) => set({ target })} />
        <label>{words.further}
          <textarea rows={3} value={wish.further} aria-invalid={wrongLine !== null} onChange={(event) => set({ further: event.target.value })} />
        </label>
        {wrongLine !== null && <p className="error">{words.badLine(wrongLine)}</p>}
      </details>
    </>
  );
}

function Buffer({ title, wish, onChange }: { title: string; wish: BufferWish; onChange: (wish: BufferWish) => void }) {
  const words = useTexts().connect;
  return (
    <fieldset className="grid">
      <legend>{title}</legend>
      <Amount label={words.length} value={wish.length} onChange={(length) => onChange({ ...wish, length })} />
      <Choice label={words.full} value={wish.full} options={same('overwrite', 'do_nothing', 'block')} onChange={(full) => onChange({ ...wish, full })} />
      <Choice label={words.empty} value={wish.empty} options={same('readback', 'do_nothing', 'block')} onChange={(empty) => onChange({ ...wish, empty })} />
    </fieldset>
  );
}

const same = (...values: string[]): Record<string, string> => Object.fromEntries(values.map((value) => [value, value]));

interface FieldProps { label: string; value: string; isDisabled?: boolean; onChange: (text: string) => void }

function Choice({ label, value, options, isDisabled = false, onChange }: FieldProps & { options: Record<string, string> }) {
  const words = useTexts().connect;
  return (
    <label>{label}
      <select value={value} disabled={isDisabled} onChange={(event) => onChange(event.target.value)}>
        <option value="">{words.byDefault}</option>
        {Object.entries(options).map(([key, text]) => <option key={key} value={key}>{text}</option>)}
      </select>
    </label>
  );
}

function Amount({ label, value, isDisabled = false, onChange }: FieldProps) {
  const words = useTexts().connect;
  return (
    <label>{label}
      <input type="number" min="0" step="any" placeholder={words.byDefault} value={value} disabled={isDisabled} onChange={(event) => onChange(event.target.value)} />
    </label>
  );
}
