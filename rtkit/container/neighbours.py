"""Lists component names in the other managers of this user on this host, to avoid clashes."""

from __future__ import annotations

from rtkit.container.operations import LATER, ContainerServices, Operations
from rtkit.deployment.message import Message
from rtkit.errors import RtkitError
from rtkit.link import zenoh_keys
from rtkit.link.places import host_name
from rtkit.link.threads import start_thread
from rtkit.logs.late import late

_TIMEOUT_S = 1.0
_log = late(__name__)


class Neighbours:
    """Asks the other managers, on a thread of its own: one that hangs holds up nobody else."""

    def __init__(self, host: ContainerServices) -> None:
        self._host = host
        self.operations: Operations = {"neighbours": self._ask}

    def _ask(self, message: Message) -> object:
        def work() -> None:
            names = sorted({name for each in _others(message["manager"]) for name in _names(each)})
            self._host.post(lambda: self._host.answer(message, names))

        start_thread(work, "neighbours")
        return LATER


def _others(manager: str) -> list[str]:
    from rtkit.link.running import managers

    return [name for name in managers() if name != manager]


def _names(manager: str) -> list[str]:
    from rtkit.deployment.listing import listing_from_text

    try:
        text = _listing(manager)
        return [row.instance for row in listing_from_text(text).rows]
    except RtkitError as error:
        _log().warning("names in manager %s are not known: %s", manager, error)
        return []


def _listing(manager: str) -> str:
    from rtkit.link.requests.manager_link import open_link

    host = host_name()
    link = open_link(manager, host, _TIMEOUT_S)
    try:
        service = zenoh_keys.service(host, manager)
        return link.call(zenoh_keys.extension_key(service, "listing"), None, _TIMEOUT_S).value()
    finally:
        link.close()
