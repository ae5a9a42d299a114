"""Finds out why a slave ended that was to live, and logs it."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from rtkit.container.exit_diagnostics import culprits, exit_diagnostics, log_crash
from rtkit.fast_dataclass import replace
from rtkit.manager.core import events as ev
from rtkit.manager.core.state import ManagerState

_log = logging.getLogger(__name__)


def with_exit_diagnostics(
    state: ManagerState,
    event: ev.SlaveEnded,
    running_on: Callable[[int, int], str],
    limit_reason: Callable[[int, str, str], str] | None,
) -> ev.SlaveEnded:
    """Return the end of a slave with its reason and last words, and log both.

    Args:
        state: The manager's.
        event: The end as the zygote reported it.
        running_on: Returns whose code ran last on a thread of a process.
        limit_reason: Adds the limit that it reached, if it did; None where nothing is limited.
    """
    process = state.processes.get(event.key)
    if process is None or not process.is_alive or not process.is_wanted:
        return event
    if process.is_guest:
        _log.info("guest %s left", process.name)
        return event
    words = exit_diagnostics(state.name, process.name, process.pid)
    held = {each: state.components[each].code for each in state.held_by(event.key)}
    if words.stacks:
        running = running_on(event.key, words.thread)
        instances = culprits(words, running, held)
        log_crash(state.name, process.name, process.pid, words, instances)
    reason = words.reason(event.reason)
    if limit_reason is not None:
        reason = limit_reason(event.key, reason, words.text)
    known = replace(event, reason=reason, last=words.text, time=time.time())
    last_words = f"; its last words: {known.last}" if known.last else ""
    _log.warning("slave %s ended: %s%s", process.name, known.reason, last_words)
    for each in held:
        _log.warning("%s was lost: %s", each, known.reason, extra={"about": each})
    return known
