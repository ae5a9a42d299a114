"""Assembles a manager of its name, endpoints, zygote and loop; takes it down again at a signal."""

from __future__ import annotations

import logging
import os
import resource
import signal
import socket
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING

from rtkit import fault
from rtkit.container.orphans import become_subreaper, began_at
from rtkit.container.slave_checkpoint import SlaveCheckpoint
from rtkit.deployment.message import Message
from rtkit.errors import Malformed, Refused, RtkitError
from rtkit.link import places, zenoh_keys
from rtkit.link.deadline import boot_id
from rtkit.logs.logs import open_log
from rtkit.manager.child_process import ENDS_WITH
from rtkit.manager.claim import check_silence, remove_stale, take_lock
from rtkit.manager.core import events as ev
from rtkit.manager.core import manager_properties
from rtkit.manager.core.core import Core
from rtkit.manager.core.requests import NOBODY
from rtkit.manager.core.startup import StartUp
from rtkit.manager.core.state import ManagerState
from rtkit.manager.initial_state import initial_state
from rtkit.manager.predecessor.crashes import unseen_crashes
from rtkit.manager.predecessor.descendants import bear_mark, end_descendants
from rtkit.manager.predecessor.stale_resources import end_lost
from rtkit.manager.predecessor.unreported import checkpoints_of_the_dead, living_slaves
from rtkit.manager.report import WANTED_VARIABLE, Report, execute_again
from rtkit.manager.service_notifier import ServiceNotifier
from rtkit.manager.signals import catch_signals
from rtkit.manager.slaves.slave_supervisor import SlaveSupervisor
from rtkit.manager.store.writer import StoreWriter
from rtkit.rtc.manager_address import parse_address
from rtkit.settings.configuration import (
    CommandLineSettings,
    read,
    tcp_endpoint_settings,
    wanted_from_text,
)
from rtkit.settings.properties import STRICT, Settings

if TYPE_CHECKING:
    from rtkit.manager.loop import Loop

_log = logging.getLogger(__name__)
_DATA_SUFFIX = ".data"
_DESCRIPTORS = 65_536
_HOLDER_S = 2.0
"""Grace for components of the manager's own process at the end [s]."""


def run(name: str, wanted: CommandLineSettings, is_shown: bool = False) -> int:
    """Run the manager of that name until its end is requested; return the exit status.

    Its starter receives when it answers, or why it does not start. A restart never returns.

    Args:
        name: Of the manager.
        wanted: Properties of the command line.
        is_shown: It runs in the foreground: what is logged goes to stderr too.
    """
    report, folder = Report(), os.getcwd()
    _forget_folder(folder)
    try:
        configuration = read(wanted)
        fault.check(configuration.settings.flag(fault.ALLOW_KEY))
        with ExitStack() as stack:
            dead = _claim(name, is_shown, stack)
            for text in configuration.warnings:
                report.warn(text)
            state = initial_state(name, folder, configuration.settings)
            notifier = ServiceNotifier(state, os.environ)  # before it has children
            keeper, remembered = _recall(state, report.warn, stack)
            loop = _assemble(state, dead, keeper, is_shown, report.warn, stack)
            loop.notifier = notifier
            loop.recall(remembered)
            done = partial(_started, loop, keeper, report, state.settings)
            start_up = StartUp(state, loop.requests, loop.post, done, report.warn)
            _register(loop, state, stack)
            loop.connections.settle(start_up.restore)
            loop.run()
            fault.point("manager.finished")
    except RtkitError as error:
        if not report.is_awaited:
            raise
        report.give_up(str(error))
        return error.exit_code
    if loop.query_server.restart is not None:
        given = {} if is_shown else {WANTED_VARIABLE: _with_port(wanted, state).to_text()}
        taken_out = {**loop.notifier.variables, **given}
        execute_again(folder, loop.query_server.restart.report, taken_out)
    return 1 if loop.has_failed else 0


def _with_port(wanted: CommandLineSettings, state: ManagerState) -> CommandLineSettings:
    """Return settings by which clients with certificates find the manager where it was."""
    at = state.properties["rtkit.tls_address"]
    return wanted._replace(overrides=(*wanted.overrides, *([f"net.tls:{at}"] if at else [])))


def _recall(
    state: ManagerState, warn: Callable[[str], None], stack: ExitStack
) -> tuple[StoreWriter, ev.StoreRead]:
    """Open the store; return it with what an earlier manager kept there.

    Raises:
        Refused: It is in use, or of a newer rtkit.
    """
    keeper = StoreWriter(places.store_file(state.name))
    stack.callback(keeper.close)
    rows: list[ev.Row]
    if not state.settings.flag("rtkit.restore"):
        rows, remark = [], keeper.set_aside()
    else:
        rows, remark = keeper.find()
    if remark:
        warn(remark)
    return keeper, ev.StoreRead(rows, boot_id(), remark, os.urandom(8).hex())


def _started(
    loop: Loop,
    keeper: StoreWriter,
    report: Report,
    settings: Settings,
    failures: list[tuple[str, str]],
) -> None:
    for what, why in failures:
        report.fail(what, why)
    if failures and settings.flag(STRICT):
        report.give_up("the manager ends, because rtkit.start.strict is YES")
        loop.has_failed = True
        loop.post(ev.StopRequested())
    else:
        fault.point("manager.settled")
        report.ready()
        fault.point("manager.ready")
        loop.notifier.ready()
        keeper.begin()
        loop.following.begin()
        loop.links.sync()


def _forget_folder(folder: str) -> None:
    """Let no file of the present folder stand in for a standard module."""
    package = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    if package != folder:
        sys.path[:] = [path for path in sys.path if path not in ("", folder)]


def _raise_limits() -> None:
    """Allow as many descriptors as may be had: each slave costs some."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = _DESCRIPTORS if hard == resource.RLIM_INFINITY else min(hard, _DESCRIPTORS)
    if soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def _claim(name: str, is_shown: bool, stack: ExitStack) -> dict[int, SlaveCheckpoint]:
    """Become the manager of that name, with its log; return what the dead held, by pid."""
    with open("/proc/self/comm", "w", encoding="utf-8", errors="replace") as comm:
        comm.write(f"rtkit {name}")
    places.make_private(places.runtime_path())
    places.make_private(places.state_dir())
    for path in places.sockets_of(name):
        places.check_socket_length(path)
    take_lock(name, stack)
    fault.point("manager.locked")
    check_silence(name)
    living = living_slaves(name)
    dead = checkpoints_of_the_dead(name, living)
    crashes = unseen_crashes(name, dead)
    left = end_descendants(name)
    remove_stale(name, living)
    # Files of an earlier manager that was just dying at the start are seen at the end only.
    stack.callback(lambda: remove_stale(name, living_slaves(name)))
    stack.callback(fault.point, "manager.unlocking")
    stack.enter_context(open_log(name, is_shown=is_shown))
    fault.point("manager.logging")
    for crash in crashes:
        crash.log(name)
    if left:
        pids = ", ".join(map(str, left))
        _log.warning("what components of a killed manager had started was ended: pids %s", pids)
    for pid in end_lost(name):
        _log.warning("a fork of an earlier manager that said nothing was ended: pid %d", pid)
    return dead


def _assemble(
    state: ManagerState,
    dead: Mapping[int, SlaveCheckpoint],
    keeper: StoreWriter,
    is_shown: bool,
    warn: Callable[[str], None],
    stack: ExitStack,
) -> Loop:
    name, host = state.name, state.host
    become_subreaper()
    bear_mark(name)
    _raise_limits()
    data = os.path.join(places.runtime_dir(), f"{name}.%p{_DATA_SUFFIX}")
    slave_supervisor = SlaveSupervisor(
        {
            "manager": name,
            "is_shown": is_shown,
            "control": places.control_socket(name),
            "data": data,
            "host": host,
            "load_path": manager_properties.load_paths(state),
            "zygote": places.zygote_pattern(name),
        },
        dead,
    )
    stack.callback(slave_supervisor.close)
    fault.point("manager.zygote_started")
    loop = _open_endpoints(state, data, slave_supervisor, keeper, warn, stack)
    signal.set_wakeup_fd(loop.wake_descriptor, warn_on_full_buffer=False)
    stack.callback(signal.set_wakeup_fd, -1)
    catch_signals(loop.post, is_shown=is_shown)
    _end_with(os.environ.get(ENDS_WITH, ""), loop, stack)
    return loop


def _end_with(owner: str, loop: Loop, stack: ExitStack) -> None:
    """Have the manager end as soon as a process does, ``PID`` or ``PID:BEGAN`` [ticks].

    Raises:
        Malformed: That is no process.
        Refused: It has ended.
    """
    if not owner:
        return
    pid, _, began = owner.partition(":")
    if not pid.isdecimal():
        raise Malformed(f"{ENDS_WITH}={owner}: not the number of a process")
    try:
        pidfd = os.pidfd_open(int(pid))
    except (OSError, OverflowError):
        raise Refused(f"{ENDS_WITH}={owner}: that process has ended") from None
    stack.callback(os.close, pidfd)
    if began and began != str(began_at(int(pid))):  # another one has its number now
        raise Refused(f"{ENDS_WITH}={owner}: that process has ended")
    loop.end_with(pidfd)


def _open_endpoints(
    state: ManagerState,
    data: str,
    slave_supervisor: SlaveSupervisor,
    keeper: StoreWriter,
    warn: Callable[[str], None],
    stack: ExitStack,
) -> Loop:
    from rtkit.link.places import remove_socket
    from rtkit.link.zenoh import ZenohLink, open_listener, unix_endpoint
    from rtkit.manager.endpoints.listening_process import TcpEndpoint
    from rtkit.manager.endpoints.ports import open_ports
    from rtkit.manager.loop import Loop

    name, host = state.name, state.host
    inner = unix_endpoint(places.manager_socket(name))
    endpoint = (
        TcpEndpoint(inner) if tcp_endpoint_settings(state.settings).port is not None else None
    )
    if endpoint is not None:
        stack.callback(endpoint.close)  # whatever else fails
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(places.control_socket(name))
    listener.listen(128)
    listener.setblocking(False)
    stack.callback(remove_socket, places.control_socket(name))
    stack.callback(listener.close)
    stack.callback(fault.point, "manager.holder_ended")
    fault.point("manager.control_open")

    loop: Loop

    def report(message: Message) -> None:
        loop.post(ev.ContainerReported(ev.OWN_PROCESS, message))

    from rtkit.manager.own_container import own_container  # while the other process starts

    container = own_container(state, data, report, stack)
    loop = Loop(Core(state), container, slave_supervisor, listener, keeper)
    stack.callback(loop.close)
    thread = threading.Thread(target=container.run, name="holder", daemon=True)
    thread.start()
    stack.callback(lambda: thread.join(0.0 if state.is_in_haste else _HOLDER_S))
    stack.callback(container.close)

    session = open_listener(inner)
    link = ZenohLink(session)
    stack.callback(remove_socket, places.manager_socket(name))
    stack.callback(link.close)
    fault.point("manager.inner_open")
    loop.open_lines(link, zenoh_keys.service(host, name))
    stack.callback(loop.query_server.logs.open(link, zenoh_keys.service(host, name)))
    link.serve(zenoh_keys.service(host, name), loop.post)
    fault.point("manager.serving")
    open_ports(state, session, endpoint, inner, warn, stack)
    stack.callback(loop.take_requests_at(places.request_socket(name)))
    stack.callback(link.withdraw)  # last of all opened here, so first at the end
    stack.callback(loop.peers.end)  # but for who asks the router from inside
    fault.point("manager.doors_open")
    return loop


def _register(loop: Loop, state: ManagerState, stack: ExitStack) -> None:
    """Register with the master, if there is to be one."""
    settings = state.settings
    if settings.flag("manager.is_master"):
        return
    from rtkit.manager.registrar import Registrar

    master = parse_address(settings.text("net.master_manager"))
    every_s = settings.number("manager.update_master_manager.interval")
    if not settings.flag("manager.update_master_manager.enable"):
        every_s = 0.0
    found = ev.OperationRequested("add_master_manager", str(master), NOBODY)
    registrar = Registrar(master, state.name, every_s, lambda: loop.post(found))
    stack.callback(registrar.close)


def main() -> int:
    """Run as a process of its own: name, and properties of the command line."""
    wanted = wanted_from_text(os.environ.pop(WANTED_VARIABLE))
    return run(sys.argv[1], wanted)


if __name__ == "__main__":
    status = main()
    os._exit(status)  # component threads that hang must not keep the process
