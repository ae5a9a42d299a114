"""Makes what holds the components of the manager's own process."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from rtkit.container.component_factory import ComponentFactory
from rtkit.container.container import ComponentContainer
from rtkit.container.heartbeats import Heartbeats, heartbeats_path
from rtkit.container.port_wiring import PortWiring
from rtkit.container.process_settings import add_log_files, configure
from rtkit.container.stdin import give_stdin
from rtkit.deployment.message import Message
from rtkit.link import places
from rtkit.link.local.streams import LocalStreams
from rtkit.manager.core import manager_properties
from rtkit.manager.core.state import ManagerState
from rtkit.modules.loader import Loader


def own_container(
    state: ManagerState, data: str, report: Callable[[Message], object], stack: ExitStack
) -> ComponentContainer:
    """Return what holds the components of the manager's own process."""
    loader = Loader(manager_properties.load_paths(state), imports_untried=False)
    configure(manager_properties.message(state), loader)
    add_log_files(state.settings, state.name)
    own_data = places.of_pid(data, state.pid)
    stack.callback(places.remove_socket, own_data)
    heartbeats = Heartbeats(heartbeats_path(data, state.pid))
    container = ComponentContainer(
        report, PortWiring(state.host, LocalStreams(data), state.name), ComponentFactory(loader)
    )
    container.show_heartbeats(heartbeats)
    give_stdin(container.terminals)
    return container
