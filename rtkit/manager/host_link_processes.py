"""Supervises the processes of links to other hosts, one a link, and that of the owner."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from contextlib import suppress

from rtkit.errors import RtkitError, Unreachable
from rtkit.link import host_links, owned_files
from rtkit.link.host_links import HostLink
from rtkit.manager.core.state import ManagerState
from rtkit.manager.kept_process import KeptProcess

_log = logging.getLogger(__name__)
_LINK, _OWNER = "rtkit.hosts.link_process", "rtkit.api.owner_process"


class HostLinkProcesses:
    """Processes of links, and of the owner; called on the loop, except the threads of its own.

    Args:
        state: Of the manager whose links they are.
    """

    def __init__(self, state: ManagerState) -> None:
        self._state = state
        self._links: dict[str, tuple[str, KeptProcess]] = {}
        self._owner: KeptProcess | None = None

    def sync(self) -> None:
        """Have the links to the hosts that are desired, no others, and the owner if it owns any."""
        self._have(self._state.kept.hosts)
        files = owned_files.of_manager(self._state.name)
        if files and not self._state.kept.fences:  # of a manager that was stopped for good
            for file in files:
                owned_files.remove(file)
        self._have_owner(is_wanted=bool(files and self._state.kept.fences))

    def _have(self, wanted: Mapping[str, str]) -> None:
        for name, (text, link) in [*self._links.items()]:
            if wanted.get(name) != text:
                del self._links[name]
                link.close()
        for name, text in [*wanted.items()]:
            if name not in self._links and (holder := self._other_holder(name)):
                _log.error("host %s: manager %s has the link to it now", name, holder)
                self._state.kept.drop("host", name)
            elif name not in self._links:
                self._links[name] = text, _link_process(self._state.name, name, text)
            else:
                self._links[name][1].hasten()
        for name in host_links.hosts():
            with suppress(Unreachable):  # of one whose manager and process were killed
                if name not in wanted and host_links.read(name).manager == self._state.name:
                    host_links.remove(name)

    def _other_holder(self, host: str) -> str:
        """Return another manager that has linked a host, while this one was away; mostly empty."""
        holder = host_links.holder(host)
        return holder if holder != self._state.name else ""

    def _have_owner(self, *, is_wanted: bool) -> None:
        if self._owner is None and is_wanted:
            arguments = (_OWNER, self._state.name)
            self._owner = KeptProcess(
                arguments, lambda how: _log.error("the owner of systems ended: %s", how)
            )
        elif self._owner is not None and not is_wanted:
            self._owner.close()
            self._owner = None
        elif self._owner is not None:
            self._owner.hasten()

    def close(self) -> None:
        """End all."""
        self._have_owner(is_wanted=False)
        self._have({})


def _link_process(manager: str, name: str, text: str) -> KeptProcess:
    state = HostLink(name, manager, "", host_links.NOT_YET)

    def ended(how: str) -> None:
        why = f"the process of the link ended: {how}"
        _log.error("host %s: %s", name, why)
        with suppress(RtkitError):
            host_links.write(state._replace(why=why))

    host_links.write(state)
    return KeptProcess((_LINK, manager, text), ended, lambda: host_links.remove(name))
