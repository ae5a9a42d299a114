import { WHOLE, isWhole, wayTo, type Scope } from '../model/scope';
import { shortName } from '../model/ports';
import type { System } from '../model/system';
import { useEditor } from '../shell/contexts';
import { useTexts } from '../texts';

/** Tells that the diagram shows a part only, with the way back; a composite that is open has the composites around it here. */
export function ScopeBar({ system, scope, shown }: { system: System; scope: Scope; shown: ReadonlySet<string> | null }) {
  const words = useTexts().manage.scope;
  const { narrow } = useEditor();
  if (isWhole(scope) || !shown) return null;
  const way = scope.inside ? wayTo(scope.inside, system.components) : [];
  const limits = [scope.host, scope.manager && shortName(scope.manager), scope.type, scope.near && words.nearOf(shortName(scope.near), scope.steps)].filter(Boolean);
  return (
    <div className="scope-bar">
      {scope.inside && (
        <nav aria-label={words.path}>
          <ol>
            <li><button type="button" className="link" onClick={() => narrow({ ...scope, inside: '' })}>{words.system}</button></li>
            {way.map((one) => (
              <li key={one.id}>{one.id === scope.inside
                ? <strong aria-current="page">{one.name}</strong>
                : <button type="button" className="link" onClick={() => narrow({ ...scope, inside: one.id })}>{one.name}</button>}</li>
            ))}
          </ol>
        </nav>
      )}
      <p>{words.shows(shown.size, system.components.size)}{limits.length > 0 && `: ${limits.join(', ')}`}</p>
      {scope.near && (
        <label>{words.steps} <input type="number" min="1" max="99" value={scope.steps} onChange={(event) => narrow({ ...scope, steps: Math.max(1, Math.min(99, Math.round(Number(event.target.value)) || 1)) })} /></label>
      )}
      <button type="button" onClick={() => narrow(WHOLE)}>{words.all}</button>
    </div>
  );
}
