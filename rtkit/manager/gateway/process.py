"""Process of a gateway: serves the TLS port of a manager until that is gone.

`rtkit.manager.endpoints.listening_process` starts it and has it open ``ADDRESS PORT``. Whatever
strangers send ends here, far from the manager: they reach no session of zenoh.
"""

from __future__ import annotations

import os
import sys
from contextlib import ExitStack

from rtkit.link.endpoint_process import serve_manager
from rtkit.link.tcp_endpoint import ask_identity
from rtkit.link.zenoh import ZenohLink, open_client
from rtkit.manager.gateway.relay import ManagerRelay, open_gateway
from rtkit.serving.acceptor import bound_to
from rtkit.serving.event_loop import PropertyEventLoop

_ROUTE_S = 5.0
_ANSWER_S = 1.0
"""How long the last answers of the manager may take, which waits longer for this process [s]."""


def open_at(wanted: str, inner: str, stack: ExitStack) -> None:
    """Open the gateway, which the stack closes.

    Raises:
        RtkitError: The port is taken, there are no keys, or the manager does not answer.
    """
    address, _, port = wanted.partition(" ")
    with ExitStack() as opened:
        end = opened.enter_context(bound_to(int(port), address))
        session = open_client(inner, _ROUTE_S)
        link = ZenohLink(session)
        opened.callback(link.close)
        host = PropertyEventLoop()
        opened.callback(host.close)
        relay = ManagerRelay(host, link, ask_identity(session, _ROUTE_S))
        host.add(relay)
        open_gateway(host, end)
        host.start()
        opened.callback(relay.await_answers, _ANSWER_S)
        stack.enter_context(opened.pop_all())


if __name__ == "__main__":
    serve_manager(open_at, sys.argv[1:])
    os._exit(0)  # threads of zenoh must not keep the process
