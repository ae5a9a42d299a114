import { useRoomTexts } from '../../texts';
import { valuesTexts as en, type ValuesTexts } from '../../texts/en/values';
import { valuesTexts as ja } from '../../texts/ja/values';

export const useValuesTexts = (): ValuesTexts => useRoomTexts({ en, ja });
