"""Lists and changes the configuration sets of one component."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from rtkit.cli.components.conf import ConfRequest, Sets, values_of
from rtkit.cli.components.conf.shown import no_parameter, no_set, show_sets, show_value
from rtkit.cli.shared.app import App
from rtkit.errors import Malformed, Partial, RtkitError

if TYPE_CHECKING:
    from rtkit.deployment.actions import Action
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.static_check.blueprint import ParameterType


def of_component(app: App, facts: ComponentFacts, asked: ConfRequest) -> None:
    """List, get, set or activate what was asked of a component.

    Raises:
        NotFound: No such set or parameter.
        RtkitError: It refused.
    """
    sets, chosen = seen(facts, asked)
    set_id = asked.set_id or facts.active_set
    if asked.verb == "list":
        show_sets(facts, chosen, asked)
    elif asked.verb == "get":
        show_value(asked.arguments[0], sets[set_id], asked)
    elif asked.verb == "act":
        _activate(app, facts.instance, set_id)
    else:
        change(app, facts, {set_id: values_of(asked.arguments)})


def seen(facts: ComponentFacts, asked: ConfRequest) -> tuple[Sets, Sets]:
    """Return the visible sets, and those of them that were asked for.

    Raises:
        NotFound: There is no set of the name that was given, or is needed.
    """
    sets = visible(facts.sets, asked)
    set_id = asked.set_id or facts.active_set
    if (asked.verb in ("get", "set", "act") or asked.set_id) and set_id not in sets:
        raise no_set(set_id, sets)
    return sets, {asked.set_id: sets[asked.set_id]} if asked.set_id else sets


def visible(sets: Sets, asked: ConfRequest) -> Sets:
    """Return the visible sets."""
    return {name: sets[name] for name in sets if asked.has_hidden or not _hidden(name)}


def _hidden(name: str) -> bool:
    return len(name) > 4 and name.startswith("__") and name.endswith("__")


def change(app: App, facts: ComponentFacts, wanted: Sets, active_set: str = "") -> None:
    """Write parameters of sets, and make a set the active one; all is checked before anything.

    Raises:
        NotFound: No such parameter.
        Malformed: A text that the parameter cannot have.
        RtkitError: The component refused.
    """
    from rtkit.deployment.actions import ActivateSet, SetParameters

    check(facts, wanted, app.tell)
    actions: list[Action] = [
        SetParameters(facts.instance, set_id, values) for set_id, values in wanted.items()
    ]
    target = active_set or facts.active_set
    if target in wanted or target != facts.active_set:
        actions.append(ActivateSet(facts.instance, target))
    for result in app.tree.apply(actions) if actions else ():
        result.raise_for_error()


def check(facts: ComponentFacts, wanted: Sets, tell: Callable[[str], object]) -> None:
    """Refuse parameters that do not exist, and texts that do not fit.

    What the component says of its parameters counts, and what an RTC profile found here says of
    those of which the component says nothing. `tell` receives places that cannot be read.

    Raises:
        NotFound: No such parameter.
        Malformed: A text that the parameter cannot have.
    """
    from rtkit.component.constraint_check import misfit, misfit_of

    declared = _declared(facts, wanted, tell)
    bad: list[tuple[str, RtkitError]] = []
    for set_id, values in wanted.items():
        for name, text in values.items():
            if name not in facts.sets[set_id]:
                raise no_parameter(name, facts.sets[set_id])
            # A hidden set holds hints, not values of the parameters.
            if _hidden(set_id):
                continue
            why = misfit(facts.sets, name, text)
            known = declared.get(name)
            if known is not None and not why and text != known.default:
                why = misfit_of(known.declared, text)
            if why:
                bad.append((name, Malformed(f"{name} cannot be {text!r}: {why}")))
    if len(bad) == 1:
        raise bad[0][1]
    if bad:
        raise Partial("nothing was changed", bad)


def _declared(
    facts: ComponentFacts, wanted: Sets, tell: Callable[[str], object]
) -> Mapping[str, ParameterType]:
    """Return the constraints that an RTC profile has where the component itself has none."""
    from rtkit.component.constraint_check import CONSTRAINT_SET

    told = facts.sets.get(CONSTRAINT_SET, {})
    if all(name in told for values in wanted.values() for name in values):
        return {}
    from rtkit.cli.shared.component_profiles import profiles

    found = list(profiles((), tell, with_shipped=False))
    if not found:
        return {}
    from rtkit.static_check.stock import CandidateDocument, stocked

    catalogue, _ = stocked((CandidateDocument(*each) for each in found), {facts.type.type_name})
    match = catalogue.find(facts.type.id)
    return match.blueprint.parameters if match is not None else {}


def _activate(app: App, instance: str, set_id: str) -> None:
    from rtkit.deployment.actions import ActivateSet

    app.tree.perform(ActivateSet(instance, set_id))
