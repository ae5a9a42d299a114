import { useRoomTexts } from '../../texts';
import { logTexts as en, type LogTexts } from '../../texts/en/log';
import { logTexts as ja } from '../../texts/ja/log';

export const useLogTexts = (): LogTexts => useRoomTexts({ en, ja });
