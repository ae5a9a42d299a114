import { Handle, Position, type NodeProps } from '@xyflow/react';
import { memo } from 'react';

import { Counts } from '../parts/Counts';
import { Icon } from '../parts/icons';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';
import { Anchors } from './Anchors';
import { sideHeight, type FrameNodeType } from './graph';

/** A manager, slave or composite: a frame round what it holds, or, folded, one box with counts by state. */
export const FrameNode = memo(function FrameNode({ id, data, selected }: NodeProps<FrameNodeType>) {
  const texts = useTexts();
  const { toggleFold } = useEditor();
  const { kind, name, isFolded, state, isTroubled, why, counts } = data.frame;
  const classes = ['frame', `frame-${kind}`, isFolded && 'is-folded', isTroubled && 'is-troubled', selected && 'is-selected'];
  const label = isFolded ? texts.canvas.unfold(name) : texts.canvas.fold(name);
  return (
    <div className={classes.filter(Boolean).join(' ')}>
      <header>
        <button type="button" className="fold nodrag" aria-expanded={!isFolded} aria-label={label} title={label} onClick={() => toggleFold(id)}>
          <Icon name={isFolded ? 'shut' : 'open'} />
        </button>
        {/* A click on the name selects, as on any box; the tree does it by keys. A second button so near would be too small a target. */}
        <span className="name" title={why || id}>{name} <small>{texts.canvas.kinds[kind]}</small></span>
        {(isTroubled || kind === 'composite') && <em title={why}>{state}</em>}
      </header>
      {isFolded && <Counts counts={counts} />}
      {data.composite && <Anchors component={data.composite} box={data.box} />}
      <Handle id="target" type="target" position={Position.Left} style={{ top: sideHeight(data.box, 'left') }} isConnectable={false} />
      <Handle id="source" type="source" position={Position.Right} style={{ top: sideHeight(data.box, 'right') }} isConnectable={false} />
    </div>
  );
});
