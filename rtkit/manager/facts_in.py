"""What holders report, checked and folded into the manager's state.

A slave runs code of others: nothing that it sends is trusted to have the right shape.
"""

from __future__ import annotations

from rtkit import errors
from rtkit.deployment.actions import Result
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import Malformed, RtkitError
from rtkit.manager.events import Message
from rtkit.manager.state import State
from rtkit.rtc.enums import ReturnCode
from rtkit.rtc.plain import decode

_KEPT = ("names", "create", "process", "trouble")


def take(state: State, key: int, message: Message) -> None:
    """Fold one report of the process `key` into the state.

    Raises:
        Malformed: The report cannot be read; nothing is changed.
    """
    if "facts" in message:
        facts = decode(ComponentFacts, message["facts"])
        _check_owner(state, key, facts.instance)
        _take_facts(state, key, facts)
    elif "gone" in message:
        instance = str(message["gone"])
        if state.holders.get(instance) == key:
            state.forget(instance)
    else:
        raise Malformed(f"unknown report from process {key}: {sorted(message)}")


def _check_owner(state: State, key: int, instance: str) -> None:
    holder = state.holders.get(instance)
    known = state.components.get(instance)
    if holder not in (None, key) and known is not None and not known.zombie:
        raise Malformed(f"{instance} is held by another process")


def _take_facts(state: State, key: int, facts: ComponentFacts) -> None:
    process = state.processes.get(key)
    if process is None:
        return
    known = state.components.get(facts.instance)
    if known is not None and known.zombie:
        state.forget(facts.instance)
        known = None
    state.components[facts.instance] = facts
    state.holders[facts.instance] = key
    if known is not None:
        state.update(facts.instance, **{name: getattr(known, name) for name in _KEPT})
    else:
        state.update(facts.instance, process=process.name)


def result(message: Message) -> Result:
    """Return the result that a holder's answer tells."""
    try:
        code = ReturnCode(message.get("code", ReturnCode.OK.value))
    except ValueError:
        code = ReturnCode.ERROR
    return Result(
        code,
        str(message.get("kind", "")),
        str(message.get("why", "")),
        message.get("value", ""),
    )


def error(outcome: Result) -> RtkitError:
    """Return the error that a failed result stands for."""
    return errors.from_kind(outcome.kind, outcome.why)
