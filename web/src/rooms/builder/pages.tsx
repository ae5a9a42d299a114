import { useId } from 'react';

import { Icon } from '../../parts/icons';
import { AreaField, ChoiceField, ConstraintField, More, NumberField, PropertyField, Row, TextField, WordsField, useBuilderTexts, useEditing } from './fields';
import { DOC, INITIAL, WIDGET, freeName, portNames, rowsAt, textAt, valueAt, withRow, withValue, withoutRow, type Form } from './form';

const CALLBACKS = ['onInitialize', 'onFinalize', 'onStartup', 'onShutdown', 'onActivated', 'onDeactivated', 'onExecute', 'onAborting', 'onError', 'onReset', 'onStateUpdate', 'onRateChanged', 'onAction'];
const SIDES = ['LEFT', 'RIGHT', 'TOP', 'BOTTOM'];
const PARAMETER_TYPES = ['double', 'int', 'string', 'bool', 'vector<double>', 'vector<int>', 'short', 'long', 'float'];
const WIDGETS = ['text', 'slider.0.1', 'slider.1', 'spin', 'radio', 'checkbox', 'ordered_list'];
const INFO = 'basicInfo';

export function BasicPage() {
  return (
    <div className="fields-grid">
      <TextField place={`${INFO}.name`} isKept />
      <TextField place={`${INFO}.version`} isKept />
      <AreaField place={`${INFO}.description`} />
      <TextField place={`${INFO}.vendor`} isKept />
      <TextField place={`${INFO}.category`} isKept />
      <ChoiceField place={`${INFO}.activityType`} choices={['PERIODIC', 'SPORADIC', 'EVENTDRIVEN']} />
      <NumberField place={`${INFO}.executionRate`} />
      <ChoiceField place={`${INFO}.executionType`} choices={['PeriodicExecutionContext', 'EventDrivenExecutionContext', 'ExtTrigExecutionContext']} />
      <ChoiceField place={`${INFO}.componentType`} choices={['STATIC', 'UNIQUE', 'COMMUTATIVE']} />
      <NumberField place={`${INFO}.maxInstances`} />
      <ChoiceField place={`${INFO}.componentKind`} choices={['DataFlowComponent', 'FiniteStateMachineComponent', 'MultiModeComponent']} />
      <More>
        <TextField place={`${INFO}.rtcType`} />
        <TextField place={`${INFO}.hardwareProfile`} />
        <AreaField place={`${INFO}.abstract`} />
        <AreaField place={`${INFO}.rtcExt::comment`} />
      </More>
    </div>
  );
}

export function ActivityPage() {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  return (
    <ul className="callbacks">
      {CALLBACKS.map((name) => {
        const place = `actions.${name}`;
        const isOn = valueAt(form, `${place}.implemented`) === true;
        return (
          <li key={name}>
            <label className="check"><input type="checkbox" checked={isOn} onChange={() => change(withValue(form, `${place}.implemented`, !isOn))} /><code>{name}</code></label>
            {isOn && (
              <details>
                <summary>{texts.list.document}</summary>
                <div className="fields-grid">
                  <AreaField place={`${place}.${DOC}.description`} />
                  <AreaField place={`${place}.${DOC}.preCondition`} />
                  <AreaField place={`${place}.${DOC}.postCondition`} />
                </div>
              </details>
            )}
          </li>
        );
      })}
    </ul>
  );
}

export function DataPortsPage() {
  const texts = useBuilderTexts();
  const { form, change, types } = useEditing();
  const list = useId();
  const ports = rowsAt(form, 'dataPorts');
  const add = (portType: string, name: string, side: string) => change(withRow(form, 'dataPorts', {
    portType, name: freeName(portNames(form), name), type: 'RTC::TimedDouble', 'rtcExt::position': side,
  }));
  const own = ports.map((port, index) => ({ port, index })).filter(({ port }) => port.portType !== 'EventPort');
  return (
    <>
      <datalist id={list}>{types.map((type) => <option key={type} value={type} />)}</datalist>
      {own.length === 0 && <p className="empty">{texts.list.noPorts}</p>}
      {own.map(({ port, index }) => {
        const place = `dataPorts.${index}`;
        const doc = `${place}.${DOC}`;
        return (
          <Row key={index} place="dataPorts" index={index} count={ports.length} name={textAt(port, 'name')}>
            <TextField place={`${place}.name`} isKept />
            <ChoiceField place={`${place}.portType`} choices={['DataInPort', 'DataOutPort']} />
            <TextField place={`${place}.type`} list={list} isKept />
            <TextField place={`${place}.unit`} />
            <More>
              <TextField place={`${place}.rtcExt::variableName`} />
              <ChoiceField place={`${place}.rtcExt::position`} choices={SIDES} />
              <TextField place={`${place}.idlFile`} />
              <TextField place={`${place}.interfaceType`} />
              <TextField place={`${place}.dataflowType`} />
              <TextField place={`${place}.subscriptionType`} />
              <ConstraintField place={`${place}.constraint`} />
              <AreaField place={`${place}.rtcExt::comment`} />
            </More>
            <More label={texts.list.document}>
              <AreaField place={`${doc}.description`} />
              <TextField place={`${doc}.type`} />
              <TextField place={`${doc}.number`} />
              <TextField place={`${doc}.unit`} />
              <TextField place={`${doc}.semantics`} />
              <TextField place={`${doc}.operation`} />
              <TextField place={`${doc}.occurrence`} />
            </More>
          </Row>
        );
      })}
      <div className="buttons">
        <button type="button" onClick={() => add('DataInPort', 'in', 'LEFT')}><Icon name="plus" />{texts.list.addIn}</button>
        <button type="button" onClick={() => add('DataOutPort', 'out', 'RIGHT')}><Icon name="plus" />{texts.list.addOut}</button>
      </div>
    </>
  );
}

export function ServicePortsPage() {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const ports = rowsAt(form, 'servicePorts');
  const add = () => change(withRow(form, 'servicePorts', { name: freeName(portNames(form), 'service'), 'rtcExt::position': 'LEFT' }));
  return (
    <>
      {ports.length === 0 && <p className="empty">{texts.list.noServices}</p>}
      {ports.map((port, index) => {
        const place = `servicePorts.${index}`;
        return (
          <Row key={index} place="servicePorts" index={index} count={ports.length} name={textAt(port, 'name')}>
            <TextField place={`${place}.name`} isKept />
            <ChoiceField place={`${place}.rtcExt::position`} choices={SIDES} />
            <More label={texts.list.document}>
              <AreaField place={`${place}.${DOC}.description`} />
              <AreaField place={`${place}.${DOC}.ifdescription`} />
            </More>
            <Interfaces place={`${place}.serviceInterface`} rows={rowsAt(port, 'serviceInterface')} />
          </Row>
        );
      })}
      <div className="buttons"><button type="button" onClick={add}><Icon name="plus" />{texts.list.addService}</button></div>
    </>
  );
}

function Interfaces({ place, rows }: { place: string; rows: readonly Form[] }) {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const names = rows.map((row) => textAt(row, 'name'));
  const add = () => change(withRow(form, place, { name: freeName(names, 'interface'), direction: 'Provided', type: '' }));
  return (
    <section className="wide" aria-label={texts.list.interfaces}>
      <h4>{texts.list.interfaces}</h4>
      {rows.map((row, index) => {
        const at = `${place}.${index}`;
        return (
          <Row key={index} place={place} index={index} count={rows.length} name={textAt(row, 'name')}>
            <TextField place={`${at}.name`} isKept />
            <ChoiceField place={`${at}.direction`} choices={['Provided', 'Required']} />
            <TextField place={`${at}.type`} isKept />
            <TextField place={`${at}.idlFile`} />
            <More>
              <TextField place={`${at}.instanceName`} />
              <TextField place={`${at}.rtcExt::variableName`} />
              <TextField place={`${at}.path`} />
            </More>
            <More label={texts.list.document}>
              {['description', 'docArgument', 'docReturn', 'docException', 'docPreCondition', 'docPostCondition'].map((key) => <AreaField key={key} place={`${at}.${DOC}.${key}`} />)}
            </More>
          </Row>
        );
      })}
      <button type="button" onClick={add}><Icon name="plus" />{texts.list.addInterface}</button>
    </section>
  );
}

const PARAMETERS = 'configurationSet.configuration';

export function ConfigurationPage() {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const list = useId();
  const rows = rowsAt(form, PARAMETERS);
  const add = () => change(withRow(form, PARAMETERS, { name: freeName(rows.map((row) => textAt(row, 'name')), 'parameter'), type: 'double', defaultValue: '0.0' }));
  return (
    <>
      <datalist id={list}>{PARAMETER_TYPES.map((type) => <option key={type} value={type} />)}</datalist>
      {rows.length === 0 && <p className="empty">{texts.list.noParameters}</p>}
      {rows.map((row, index) => {
        const place = `${PARAMETERS}.${index}`;
        const doc = `${place}.${DOC}`;
        return (
          <Row key={index} place={PARAMETERS} index={index} count={rows.length} name={textAt(row, 'name')}>
            <TextField place={`${place}.name`} isKept />
            <TextField place={`${place}.type`} list={list} isKept />
            <TextField place={`${place}.defaultValue`} isKept />
            <ConstraintField place={`${place}.constraint`} />
            <TextField place={`${place}.unit`} />
            <PropertyField place={place} name={WIDGET} label="widget" choices={WIDGETS} />
            <More>
              <TextField place={`${place}.rtcExt::variableName`} />
              <AreaField place={`${place}.rtcExt::comment`} />
            </More>
            <More label={texts.list.document}>
              <AreaField place={`${doc}.description`} />
              <TextField place={`${doc}.dataname`} />
              <TextField place={`${doc}.defaultValue`} />
              <TextField place={`${doc}.unit`} />
              <TextField place={`${doc}.range`} />
              <TextField place={`${doc}.constraint`} />
            </More>
          </Row>
        );
      })}
      <div className="buttons"><button type="button" onClick={add}><Icon name="plus" />{texts.list.addParameter}</button></div>
    </>
  );
}

export function MachinePage() {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const index = rowsAt(form, 'dataPorts').findIndex((port) => port.portType === 'EventPort');
  const addMachine = () => change(withRow(form, 'dataPorts', {
    portType: 'EventPort', name: freeName(portNames(form), 'event'), type: 'RTC::TimedString', 'rtcExt::position': 'LEFT',
    event: [{ name: '', source: INITIAL, target: 'Idle' }, { name: 'start', source: 'Idle', target: 'Busy' }, { name: 'stop', source: 'Busy', target: 'Idle' }],
  }));
  if (index < 0) return <><p className="note">{texts.list.machineHint}</p><div className="buttons"><button type="button" onClick={addMachine}><Icon name="plus" />{texts.list.addMachine}</button></div></>;
  const port = `dataPorts.${index}`;
  const place = `${port}.event`;
  const rows = rowsAt(form, place);
  const first = rows.findIndex((row) => row.source === INITIAL && !textAt(row, 'name'));
  const add = () => change(withRow(form, place, { name: 'event', source: textAt(rows.at(-1) ?? {}, 'target'), target: '' }));
  return (
    <>
      <p className="note">{texts.list.machineHint}</p>
      <div className="fields-grid">
        <TextField place={`${port}.name`} isKept />
        {first >= 0 && <TextField place={`${place}.${first}.target`} label="initial" isKept />}
      </div>
      <h4>{texts.list.transitions}</h4>
      {rows.map((row, at) => at !== first && (
        <Row key={at} place={place} index={at} count={rows.length} name={textAt(row, 'name')}>
          <TextField place={`${place}.${at}.name`} label="event" isKept />
          <TextField place={`${place}.${at}.source`} isKept />
          <TextField place={`${place}.${at}.target`} isKept />
          <TextField place={`${place}.${at}.type`} />
          <TextField place={`${place}.${at}.condition`} className="wide" />
        </Row>
      ))}
      <div className="buttons">
        <button type="button" onClick={add}><Icon name="plus" />{texts.list.addTransition}</button>
        <button type="button" className="danger" onClick={() => change(withoutRow(form, 'dataPorts', index))}>{texts.list.remove(texts.pages.machine)}</button>
      </div>
    </>
  );
}

export function DocumentationPage() {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const doc = `${INFO}.${DOC}`;
  const logs = `${INFO}.rtcExt::versionUpLogs`;
  const entries = valueAt(form, logs);
  const count = Array.isArray(entries) ? entries.length : 0;
  return (
    <>
      <div className="fields-grid">
        {['description', 'inout', 'algorithm'].map((key) => <AreaField key={key} place={`${doc}.${key}`} rows={4} />)}
        <TextField place={`${doc}.creator`} />
        <TextField place={`${doc}.license`} />
        <AreaField place={`${doc}.reference`} />
      </div>
      <h4>{texts.list.logs}</h4>
      {Array.from({ length: count }, (_, index) => (
        <Row key={index} place={logs} index={index} count={count} name={String(index + 1)}><AreaField place={`${logs}.${index}`} label="log" /></Row>
      ))}
      <div className="buttons"><button type="button" onClick={() => change(withRow(form, logs, ''))}><Icon name="plus" />{texts.list.addLog}</button></div>
    </>
  );
}

export function LanguagePage() {
  const texts = useBuilderTexts();
  const { form, change } = useEditing();
  const place = 'language.rtcExt::targets';
  const rows = rowsAt(form, place);
  return (
    <>
      <div className="fields-grid"><ChoiceField place="language.kind" choices={['Python', 'C++', 'Java', 'C#']} /></div>
      <p className="note">{texts.list.onlyPython}</p>
      <h4>{texts.list.targets}</h4>
      {rows.map((row, index) => {
        const at = `${place}.${index}`;
        const libraries = rowsAt(row, 'libraries');
        return (
          <Row key={index} place={place} index={index} count={rows.length} name={textAt(row, 'os') || textAt(row, 'langVersion')}>
            <TextField place={`${at}.langVersion`} />
            <TextField place={`${at}.os`} />
            <WordsField place={`${at}.osVersions`} />
            <WordsField place={`${at}.cpus`} />
            <TextField place={`${at}.cpuOther`} />
            <TextField place={`${at}.other`} />
            <section className="wide" aria-label={texts.list.libraries}>
              <h4>{texts.list.libraries}</h4>
              {libraries.map((library, number) => (
                <Row key={number} place={`${at}.libraries`} index={number} count={libraries.length} name={textAt(library, 'name')}>
                  <TextField place={`${at}.libraries.${number}.name`} isKept />
                  <TextField place={`${at}.libraries.${number}.version`} />
                  <TextField place={`${at}.libraries.${number}.other`} />
                </Row>
              ))}
              <button type="button" onClick={() => change(withRow(form, `${at}.libraries`, { name: freeName(libraries.map((one) => textAt(one, 'name')), 'library') }))}><Icon name="plus" />{texts.list.addLibrary}</button>
            </section>
          </Row>
        );
      })}
      <div className="buttons"><button type="button" onClick={() => change(withRow(form, place, { langVersion: '3.11', os: 'Linux' }))}><Icon name="plus" />{texts.list.addTarget}</button></div>
    </>
  );
}
