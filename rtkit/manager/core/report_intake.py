"""Checks reports of containers and folds them into the manager's state.

A slave runs code of others: nothing that it sends is trusted to have the right shape.
"""

from __future__ import annotations

from rtkit import errors
from rtkit.deployment.actions import Result
from rtkit.deployment.facts import ComponentFacts, RestartStatus
from rtkit.deployment.message import Message
from rtkit.errors import Malformed, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.manager.core.state import ManagerState, Process
from rtkit.rtc.enums import ReturnCode
from rtkit.rtc.serde import decode


def take(state: ManagerState, process: Process, report: object) -> ComponentFacts:
    """Fold the facts of one component, as its process reports them, into the state.

    Raises:
        Malformed: They cannot be read, or are none of its business; nothing is changed.
    """
    facts = decode(ComponentFacts, report)
    instance = facts.instance
    known = state.components.get(instance)
    claim = state.claims.get(instance)
    if state.containers.get(instance) != process.key:
        if claim is None or claim.key != process.key:
            raise Malformed(f"{process.name} reports {instance}, which it does not hold")
        if known is not None:
            state.forget(instance)
            known = None
    trouble = state.trouble_of(instance, process)
    facts = _completed(facts, known, process, trouble, state.restart_status_of(instance))
    state.components[instance] = facts
    state.containers[instance] = process.key
    return facts


def _completed(
    facts: ComponentFacts,
    known: ComponentFacts | None,
    process: Process,
    trouble: str,
    restart_status: RestartStatus,
) -> ComponentFacts:
    """Return the facts with those that are the manager's own, whatever was reported of them."""
    return replace(
        facts,
        process=process.name,
        names=known.names if known is not None else (),
        create=known.create if known is not None else "",
        trouble=trouble,
        zombie="",
        restart_status=restart_status,
    )


def result(message: Message) -> Result:
    """Return the result in a container's answer."""
    try:
        code = ReturnCode(message.get("code", ReturnCode.OK.value))
    except ValueError:
        code = ReturnCode.ERROR
    return Result(code, str(message.get("kind", "")), str(message.get("why", "")))


def error(outcome: Result) -> RtkitError:
    """Return the error that a failed result stands for."""
    return errors.from_kind(outcome.kind, outcome.why)
