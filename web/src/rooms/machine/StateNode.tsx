import { Handle, Position, type NodeProps } from '@xyflow/react';
import { memo } from 'react';

import { StateIcon } from '../../parts/StateIcon';
import { rowHeight, type StateNodeType } from './chart';
import { useMachineTexts } from './useMachine';

/** A state: name, signs of what it is, what it does, and its transitions in rows; others may lie inside. */
export const StateNode = memo(function StateNode({ data, selected }: NodeProps<StateNodeType>) {
  const texts = useMachineTexts();
  const { box, name, isInitial, isFinal, isActive, sign, problem, isOdd, ways, canEdit } = data;
  const classes = ['state', `is-${box.kind}`, isActive && 'is-active', isFinal && 'is-final', selected && 'is-selected', sign && 'is-changed', problem && (isOdd ? 'is-odd' : 'is-wrong')];
  return (
    <div className={classes.filter(Boolean).join(' ')} title={problem || data.path}>
      <header>
        {isInitial && <i className="dot" title={texts.initial} />}
        <strong>{name}</strong>
        {isFinal && <i className="ring" title={texts.final} />}
        {isActive && <span className="word"><StateIcon look="active" />{texts.active}</span>}
        {problem && <span className="mark" aria-hidden="true">⚠</span>}
        {sign && <span className="sign" title={texts.signs[sign]}>{sign}</span>}
      </header>
      {box.summary && <p className="summary">{box.summary}</p>}
      <Handle id="in" type="target" position={Position.Left} style={{ top: rowHeight(box, 0) }} isConnectable={false} />
      {ways.map((way, index) => (
        <div key={way.id} className={['row', way.isSelected && 'is-selected', way.isLast && 'is-last', way.problem && 'is-wrong'].filter(Boolean).join(' ')}
          style={{ top: rowHeight(box, index) }} data-way={way.id} title={way.problem || way.text}>
          {way.sign && !sign?.startsWith('+') && <b>{way.sign}</b>}
          <span>{way.problem && '⚠ '}{way.text}</span>
          <Handle id={`row-${index}`} type="source" position={Position.Right} isConnectable={false} />
        </div>
      ))}
      {canEdit && !isFinal && <Handle id="new" className="more" type="source" position={Position.Bottom} title={texts.newWay(name)} />}
    </div>
  );
});
