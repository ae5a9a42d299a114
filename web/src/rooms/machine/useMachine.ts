import { useEffect, useReducer } from 'react';

import { useEditor } from '../../shell/contexts';
import { useRoomTexts } from '../../texts';
import { machineTexts as en } from '../../texts/en/machine';
import { machineTexts as ja } from '../../texts/ja/machine';
import { UNKNOWN, told, type Live, type Told } from './live';

export const useMachineTexts = () => useRoomTexts({ en, ja });

/** A machine as it lives, while this is shown. */
export function useMachine(id: string): Live {
  const { api } = useEditor();
  const [live, take] = useReducer(told, UNKNOWN);
  useEffect(() => {
    if (!id) return undefined;
    return api.follow(`/api/machine/stream?of=${encodeURIComponent(id)}`, {
      onLink: (link) => link === 'lost' && take({ kind: 'gone', data: { text: '' } }),
      onEvent: ({ event, data }) => take({ kind: event, data: JSON.parse(data) as unknown } as Told),
    });
  }, [api, id]);
  return live;
}
