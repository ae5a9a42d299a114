"""Records followed systems and their outcomes: stored first, then answered."""

from __future__ import annotations

import json
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.facts import Followed
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.manager.core.desired import DesiredState
from rtkit.manager.core.durable_replies import DurableReplies, unkept
from rtkit.manager.core.events import AnswerClient, FollowAsked, FollowSaid, Instruction
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Reply, failure
from rtkit.rtc.serde import encode

_BEGIN = act.Create("")
"""Something that is not begun while nothing can be kept."""


class Follows:
    """Rows about followed systems; `out` collects instructions for the shell."""

    def __init__(
        self, state: ManagerState, out: list[Instruction], keeping: DurableReplies
    ) -> None:
        self._state = state
        self._out = out
        self._keeping = keeping

    def ask(self, asked: FollowAsked) -> None:
        """Follow a system, or follow it no more."""

        def go_on(why: str) -> None:
            try:
                if why and asked.text is not None:
                    raise Refused(unkept(why))
                text = self._change(asked)
            except RtkitError as error:
                self._out.append(AnswerClient(asked.request, failure(error)))
            else:
                self._answer_when_kept(asked.request, text)

        self._keeping.admit([_BEGIN] if asked.text is not None else [], go_on)

    def _change(self, asked: FollowAsked) -> str:
        kept, name = self._state.kept, asked.system
        known = kept.followed.get(name)
        if asked.text is None:
            if known is None:
                raise NotFound(f"manager {self._state.name!r} does not follow {name}")
            kept.drop("followed", name)
            kept.drop("reached", name)
            return f"{name} is followed no more"
        if known is not None and not kept.reached[name].is_over:
            if _about(known) == _about(asked.text):
                return f"{name} is followed already"
            raise Refused(
                f"manager {self._state.name!r} follows {name} as another profile tells it"
                f" ({_about(known)[0]}); rtstate --unfollow {name} ends that"
            )
        kept.put("followed", name, asked.text)
        kept.put("reached", name, Followed(name))
        return f"{name} is followed"

    def take_report(self, report: FollowSaid) -> None:
        """Take in what became of a system, if it is still followed."""
        if report.told.system in self._state.kept.followed:
            self._state.kept.put("reached", report.told.system, report.told)
        self._answer_when_kept(report.request, "")

    def _answer_when_kept(self, request: int, text: str) -> None:
        def answer(results: list[Result]) -> None:
            why = self._state.unkept
            reply = failure(Refused(unkept(why))) if why else Reply(results[0].value)
            self._out.append(AnswerClient(request, reply))

        self._keeping.finish([act.Tick("", "")], [Result(value=text)], answer)


def as_json(kept: DesiredState) -> str:
    """Return all systems that are followed, with their states and events, as JSON."""
    return json.dumps([_record(kept, name) for name in kept.followed])


def _record(kept: DesiredState, name: str) -> dict[str, Any]:
    spec = json.loads(kept.followed[name])
    plain = encode(kept.reached.get(name, Followed(name)))
    return {**plain, "table": spec["table"], "conditions": spec["conditions"]}


def _about(text: str) -> list[str]:
    """Return the file of the profile, and the fingerprint of its content."""
    return list(json.loads(text).get("about", ["", ""]))
