"""Finds what a manager held before: its last events are replayed, as `rtmgr replay` does.

A manager keeps its last events with the state that they began in. What its core makes of them
again is what it has told, or would have told, its observers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rtkit.deployment.delta import Delta, FullSnapshot, applied
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.user_events import UserEvent, user_events
from rtkit.errors import Malformed
from rtkit.manager.core.change_feed import ChangeFeed
from rtkit.manager.core.dump import Dump, from_lines
from rtkit.manager.core.events import AnswerClient, Instruction, Publish
from rtkit.manager.core.replay import Replay
from rtkit.rtc.serde import decode, decode_text


class PastFacts(NamedTuple):
    """Facts of a manager since one moment, until the next.

    Attributes:
        time: The moment, by the clock of its host [s since 1970].
        facts: What it held.
        events: What had happened then.
    """

    time: float
    facts: Snapshot
    events: tuple[UserEvent, ...] = ()


class ManagerPast(NamedTuple):
    """All that is known of what a manager held.

    Attributes:
        since: The first moment that is known; of a manager that has begun with nothing all are.
        steps: What it held, in order.
    """

    since: float
    steps: Sequence[PastFacts]


def past_of(text: str) -> ManagerPast:
    """Return what a manager held, by the text of its dump.

    Raises:
        Malformed: It is no dump that can be read here.
        Refused: It has no state to begin with.
    """
    dump = from_lines(text.splitlines())
    steps = list(_steps(dump))
    first = steps[0]
    has_begun = not dump.recording.lost and not first.facts.components
    return ManagerPast(-math.inf if has_begun else first.time, steps)


def _steps(dump: Dump) -> Iterator[PastFacts]:
    """Yield first what it held at the beginning, then what it held after each change."""
    offset_s = _offset(dump)
    run = Replay(dump.recording)
    out: list[Instruction] = []
    feed = ChangeFeed(run.state, out)
    feed.send_picture(0)
    facts = next(_answered(each) for each in out if isinstance(each, AnswerClient))
    out.clear()
    items = dump.recording.items
    time = items[0][0] + offset_s if items else offset_s
    yield PastFacts(time, facts)
    for step in run.steps():
        feed.run()
        time = max(time, step.at + offset_s)
        for each in out:
            if isinstance(each, Publish):
                delta = decode(Delta, each.message)
                events, facts = tuple(user_events(facts, delta)), applied(facts, delta)
                yield PastFacts(time, facts, events)
        out.clear()


def _answered(answer: AnswerClient) -> Snapshot:
    return decode_text(FullSnapshot, answer.reply.text).facts


def _offset(dump: Dump) -> float:
    """Return what to add to a monotonic time of the dump [s]."""
    try:
        clock, monotonic = (float(dump.header[key]) for key in ("clock", "monotonic"))
    except (KeyError, ValueError):
        raise Malformed("not a dump that tells when it was: it is of another rtkit") from None
    offset_s = clock - monotonic
    if not math.isfinite(offset_s):
        raise Malformed("not a dump that tells when it was")
    return offset_s
