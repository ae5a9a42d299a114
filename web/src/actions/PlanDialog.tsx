import { Modal } from '../parts/Modal';
import { useTexts } from '../texts';
import type { Asked } from './useActions';

/** Shows what will be done, step by step, before it is done. */
export function PlanDialog({ asked }: { asked: Asked }) {
  const texts = useTexts();
  const { label, plan, ends, answer } = asked;
  return (
    <Modal title={`${texts.plan.title}: ${label}`} className="plan" onClose={() => answer(false)}>
      <p>{texts.plan.lead(plan.steps.length)}</p>
      <ol>
        {plan.steps.map((step, index) => (
          <li key={index} className={step.ok === false ? 'is-bad' : ''}>
            {step.text}
            {step.command && <code>{step.command}</code>}
            {step.error && <span className="error">{step.error}</span>}
          </li>
        ))}
      </ol>
      {ends && <p className="warning">{plan.undo === null ? texts.plan.ends : texts.manage.keptEnds}</p>}
      {!ends && plan.undo === null && plan.undo_reason && <p className="warning">{texts.plan.noUndo(plan.undo_reason)}</p>}
      <footer>
        <button type="button" onClick={() => answer(false)}>{texts.plan.cancel}</button>
        {/* What can be undone is one Enter away; what ends components is not. */}
        {/* eslint-disable-next-line jsx-a11y/no-autofocus */}
        <button type="button" autoFocus={!ends} className={ends ? 'danger filled' : 'primary'} onClick={() => answer(true)}>{texts.plan.go}</button>
      </footer>
    </Modal>
  );
}
