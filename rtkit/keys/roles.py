"""Roles in certificates, and what each may do.

A viewer may GET and listen. An operator may SET as well. A component may GET, and SET what a rule
allows it by its name. Rules of a service count for all of them; no rule lets a viewer SET. Of a
manager an operator may have components change, and only an administrator may have things made and
ended, since that runs code.
"""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.property.access import Access, AccessRule

ROLE_PREFIX = "rtkit:role:"
ROLES = ("administrator", "operator", "viewer", "component")
_RANKS = {"administrator": 3, "operator": 2, "viewer": 1, "component": 1}


def role_of(uris: Iterable[str]) -> str:
    """Return the one role among the names of the kind URI, empty if there is none."""
    found = [each.removeprefix(ROLE_PREFIX) for each in uris if each.startswith(ROLE_PREFIX)]
    return found[0] if len(found) == 1 and found[0] in ROLES else ""


def includes(role: str, needed: str) -> bool:
    """Return whether a role may do all that another one may at a manager."""
    return _RANKS.get(role, 0) >= _RANKS[needed]


class RoleAccess(Access):
    """Rules that hold for who has a role."""

    def __init__(self, rules: Iterable[AccessRule], role: str) -> None:
        super().__init__(rules)
        self._role = role

    def may(self, identity: str, method: str, name: str) -> bool:
        """See `Access.may`."""
        if method == "GET" or includes(self._role, "operator"):
            return super().may(identity, method, name)
        # Without any rule the general answer would be yes for whoever is known.
        return self._role == "component" and self.allows(identity, method, name)
