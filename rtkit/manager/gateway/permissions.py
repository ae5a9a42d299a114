"""Permissions of other hosts at a manager: what a request is, in words, and the role it takes.

Making components runs code of this user, so that takes an administrator; an operator has those
change that are there; a viewer looks. Requests that are not named here take an administrator, or
are for nobody on another host.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.batch import batch_from_text
from rtkit.deployment.terminal import question_from_text
from rtkit.errors import Malformed, Refused
from rtkit.keys.roles import includes
from rtkit.rtc.far_ends import peer_of

VIEWER, OPERATOR, ADMINISTRATOR = "viewer", "operator", "administrator"
LOCK = "@x/lease"
"""Lock of a manager, which whoever carries a plan out takes."""
_OF_OPERATORS = (
    act.ActivateSet, act.ChangeState, act.Connect, act.Disconnect, act.RemoveSet,
    act.SetParameters, act.SetRate, act.Tick,
)  # fmt: skip
_VIEWS = ("listing", "snapshot", "part", "picture", "events", "lease", "line", "clock")
_QUESTIONS = ("logs", "samples")
_TERMINAL = "@x/terminal"
"""Views of which the payload says what is wanted."""
RESTART = "@/restart"
ROUTER = "@x/router"
"""Bytes to and from the router of a manager, by which hosts are linked."""
_HALF = "@x/half"
"""Requests between managers of linked hosts."""
_STEPS = r"(/[^/*$?#\s\x00-\x1f]+)+"
_NAME = re.compile(rf"@{_STEPS}(\?id=[0-9a-f-]{{1,64}})?|@x{_STEPS}")
"""Operations may bear an id; what is reserved is looked at by its name, to which nothing is added.
"""
_LONGEST = 1000
_MOST_NAMED = 3


class Permission(NamedTuple):
    """Permission that a request to a manager takes.

    Attributes:
        role: The least that may send it.
        what: Names it to people.
    """

    role: str
    what: str


def permission(name: str, payload: str | None) -> Permission:
    """Return what a request takes.

    Args:
        name: Its key below that of the manager: ``@/manager.pid``, ``@x/listing``.
        payload: Of a SET; None for a GET.

    Raises:
        Malformed: It is none.
        Refused: It is for nobody on another host.
    """
    if len(name) > _LONGEST or not _NAME.fullmatch(name):
        raise Malformed(f"not a property of a manager: {name[:80]!r}")
    name = name.partition("?")[0]
    mark, _, rest = name.partition("/")
    if name == _HALF:
        raise Refused("halves of connectors are made over links (rthost add) only")
    if name == RESTART and payload not in (None, "", "forget"):
        raise Refused("a restart is reported to processes of the manager's own host only")
    if name == ROUTER and payload is not None:
        return Permission(ADMINISTRATOR, f"link host {shown(payload.partition(' ')[0])}")
    if name == LOCK and payload is not None:
        return Permission(OPERATOR, "take the lock of plans")
    if name == _TERMINAL and payload is not None:
        asked = question_from_text(payload)
        role = OPERATOR if asked["input"] or asked["size"] else VIEWER
        does = "type to" if role == OPERATOR else "look at the terminal of"
        return Permission(role, f"{does} {shown(asked['instance'])}")
    if name == "@/batch" and payload is not None:
        return _of_batch(batch_from_text(payload).actions)
    if mark == "@x":
        is_view = (payload is None and rest.partition("/")[0] in _VIEWS) or rest in _QUESTIONS
        what = "look for modules" if rest == "lacking" else f"get {rest}"
        return Permission(VIEWER if is_view else ADMINISTRATOR, what)
    if payload is None or rest == "get_components_by_name":
        return Permission(VIEWER, f"get {rest}")
    return Permission(ADMINISTRATOR, f"set {rest}")


def _of_batch(actions: Sequence[Action]) -> Permission:
    """Return what a batch takes, named by those of its actions that take most."""
    found = [_of_action(action) for action in actions]
    role = VIEWER
    for each in found:
        role = role if includes(role, each.role) else each.role
    named = [each.what for each in found if each.role == role]
    more = len(named) - _MOST_NAMED
    words = ", ".join(named[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
    return Permission(role, words or "do nothing")


def _of_action(action: Action) -> Permission:
    role = OPERATOR if isinstance(action, _OF_OPERATORS) else ADMINISTRATOR
    if isinstance(action, act.ChangeState):
        return Permission(role, f"{action.transition} {shown(action.instance)}")
    if isinstance(action, act.Connect):
        ports = " and ".join(str(each) for each in action.connector.ports)
        # The manager at the other end has not been asked who this is.
        role = ADMINISTRATOR if peer_of(action.connector) else role
        return Permission(role, f"connect {shown(ports)}")
    verb = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(action).__name__).lower()
    # Properties behind the type of what is made may be secrets.
    whom = str(getattr(action, type(action).__match_args__[0]))
    return Permission(role, f"{verb} {shown(whom.partition('?')[0])}")


def shown(text: str) -> str:
    """Return a name of a client as a record and a terminal show it."""
    return "".join(c if c.isprintable() else "?" for c in text)[:60]
