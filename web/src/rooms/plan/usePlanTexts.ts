import { useRoomTexts } from '../../texts';
import { planTexts as en, type PlanTexts } from '../../texts/en/plan';
import { planTexts as ja } from '../../texts/ja/plan';

export type { PlanTexts };

export const usePlanTexts = (): PlanTexts => useRoomTexts({ en, ja });
