"""Configuration sets of components: parameters checked and changed, sets added and removed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from rtkit.errors import Malformed, NotFound, Partial, Refused, RtkitError

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.actions import Action
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.static_check.blueprint import ParameterType

Sets = Mapping[str, Mapping[str, str]]


def change(session: Session, facts: ComponentFacts, wanted: Sets, active_set: str = "") -> None:
    """Write parameters of sets, and make a set the active one; all is checked before anything.

    A set that is not there is added.

    Raises:
        NotFound: No such parameter.
        Malformed: A text that the parameter cannot have.
        RtkitError: The component refused.
    """
    from rtkit.deployment.actions import MISSING, ActivateSet, SetParameters

    check(facts, wanted, session.verbose)
    actions: list[Action] = [
        SetParameters(facts.instance, set_id, values, "" if set_id in facts.sets else MISSING)
        for set_id, values in wanted.items()
    ]
    target = active_set or facts.active_set
    if target in wanted or target != facts.active_set:
        actions.append(ActivateSet(facts.instance, target))
    for result in session.tree.apply(actions) if actions else ():
        result.raise_for_error()


def check(facts: ComponentFacts, wanted: Sets, notify: Callable[[str], object]) -> None:
    """Refuse parameters that do not exist, and texts that do not fit.

    What the component says of its parameters counts, and what an RTC profile found here says of
    those of which the component says nothing. `notify` receives places that cannot be read.

    Raises:
        NotFound: No such parameter.
        Malformed: A text that the parameter cannot have.
    """
    from rtkit.component.configuration.constraint_check import misfit, misfit_of, parameter_names

    declared = _declared(facts, wanted, notify)
    bad: list[tuple[str, RtkitError]] = []
    for set_id, values in wanted.items():
        for name, text in values.items():
            names = facts.sets.get(set_id, parameter_names(facts.sets))
            if name not in names:
                raise no_parameter(name, names)
            # A hidden set holds hints, not values of the parameters.
            if is_hidden(set_id):
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
    facts: ComponentFacts, wanted: Sets, notify: Callable[[str], object]
) -> Mapping[str, ParameterType]:
    """Return the constraints that an RTC profile has where the component itself has none."""
    from rtkit.component.configuration.constraint_check import CONSTRAINT_SET

    constraints = facts.sets.get(CONSTRAINT_SET, {})
    if all(name in constraints for values in wanted.values() for name in values):
        return {}
    from rtkit.api.component_profiles import profiles

    found = list(profiles((), notify, with_shipped=False))
    if not found:
        return {}
    from rtkit.static_check.stock import CandidateDocument, stocked

    catalogue, _ = stocked((CandidateDocument(*each) for each in found), {facts.type.type_name})
    match = catalogue.find(facts.type.id)
    return match.blueprint.parameters if match is not None else {}


def add(session: Session, facts: ComponentFacts, set_id: str, values: Mapping[str, str]) -> None:
    """Add a set of these values; see `rtkit.Tree.add_set`."""
    from rtkit.deployment.actions import NEW, SetParameters
    from rtkit.rtc.names import check_set_name

    if set_id in facts.sets:
        raise Refused(f"configuration set {set_id} exists already")
    check(facts, {check_set_name(set_id): values}, session.verbose)
    session.tree.perform(SetParameters(facts.instance, set_id, values, NEW))


def remove(session: Session, facts: ComponentFacts, set_id: str) -> None:
    """Remove a set; see `rtkit.Tree.remove_set`."""
    from rtkit.deployment.actions import RemoveSet

    session.tree.perform(RemoveSet(facts.instance, known(facts, set_id)))


def activate(session: Session, facts: ComponentFacts, set_id: str) -> None:
    """Make a set the active one; see `rtkit.Tree.activate_set`."""
    from rtkit.deployment.actions import ActivateSet

    session.tree.perform(ActivateSet(facts.instance, known(facts, set_id)))


def known(facts: ComponentFacts, set_id: str) -> str:
    """Return the name of a set that is there.

    Raises:
        NotFound: It is not.
    """
    if set_id not in facts.sets:
        raise no_set(set_id, facts.sets)
    return set_id


def is_hidden(name: str) -> bool:
    """Return whether a set holds hints about parameters, not values of them."""
    return len(name) > 4 and name.startswith("__") and name.endswith("__")


def no_parameter(name: str, known: Iterable[str]) -> NotFound:
    """Return the error that there is no such parameter, with similar names."""
    from rtkit.rtc.nearest import did_you_mean

    return NotFound(f"No such configuration parameter: {name}{did_you_mean(name, known)}")


def no_set(set_id: str, known: Iterable[str]) -> NotFound:
    """Return the error that there is no such set, with similar names."""
    from rtkit.rtc.nearest import did_you_mean

    return NotFound(f"No such configuration set: {set_id}{did_you_mean(set_id, known)}")
