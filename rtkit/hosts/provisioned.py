"""The rtkit of another host: made there when it is missing, and how it is started.

It is a virtual environment in the user's own folder, ``~/.local/share/rtkit/versions/ID``, with a
link ``current`` to the one in use.
"""

from __future__ import annotations

import json
import os
import posixpath
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

from rtkit import fault
from rtkit.errors import Malformed, Refused, Unreachable
from rtkit.fast_dataclass import Record
from rtkit.hosts import far_program, far_side, quiet_sftp, wheels
from rtkit.hosts.connection import HostConnection
from rtkit.hosts.far_side import FarSide
from rtkit.hosts.host import Host, named
from rtkit.hosts.progress import HostStep, Progress, unshown
from rtkit.hosts.wheels import WheelSet
from rtkit.rtc.serde import decode_text

_SILENT_S = 60.0
"""For how long nothing may come from a host while rtkit is made there [s]."""
_CHUNK = 1 << 15
_LONGEST = 1 << 20
_TURN = """
import fcntl, os, signal, sys
base = os.path.join(os.path.expanduser("~"), ".local", "share", "rtkit")
os.makedirs(base, mode=0o700, exist_ok=True)
with open(os.path.join(base, "turn"), "w") as lock:
    signal.signal(signal.SIGALRM, lambda *_: print("waiting"))
    signal.setitimer(signal.ITIMER_REAL, 0.5, 10.0)
    fcntl.flock(lock, fcntl.LOCK_EX)
    signal.setitimer(signal.ITIMER_REAL, 0)
    print(sys.argv[1] + "mine")
    sys.stdin.read()
"""
_STEPS = ("fetching", "installing")
_REASON = 200
"""How much of a reason of the host is told [characters]."""
_MOST_NAMED = 3
_TIMES = 2
"""How often what is lacking is sent: it may stand behind the beginning of another file."""


class Provisioned(NamedTuple):
    """Outcome of provisioning.

    Attributes:
        id: The version in use.
        is_new: Whether it was made.
        sent_bytes: How much was sent for it.
        damage: Files for which it was made anew.
        fetched_bytes: How much the host fetched for it.
        unfetched: Why it did not fetch others.
    """

    id: str
    is_new: bool
    sent_bytes: int
    damage: str = ""
    fetched_bytes: int = 0
    unfetched: str = ""


class _Installed(Record):
    """Answer of `rtkit.hosts.far_install`.

    Attributes:
        wheels: Folder there that wheels are sent to.
        lacking: How much of each that lacks has been sent [bytes].
        made: Whether the version is new there.
        removed: Versions that nothing used any more.
    """

    wheels: str
    lacking: dict[str, int]
    made: bool
    removed: tuple[str, ...]


def provision(
    connection: HostConnection,
    far: FarSide,
    show: Progress = unshown,
    check: Callable[[], object] = bool,
) -> Provisioned:
    """Have this rtkit on a host; what is there already is used.

    Interrupted anywhere it can be done again: a version counts when it is complete, and of what was
    sent nothing is sent twice. One of which files are gone or changed is made anew. What is to
    `check` is so before anything changes there.

    Raises:
        Refused: The host does not do; tells all that is wrong.
        NotFound: There is no wheel of something for it.
        Malformed: What it answers makes no sense.
        Unreachable: The connection ended.
    """
    name = connection.host.name
    # What has a version needs no room for another, if that is the one.
    far_side.check(far.obstacles(needs_room=not far.current), name)
    chosen = _chosen(connection.host, far, show)
    damage = ", ".join(far.damaged.get(chosen.id, ()))
    if far.current == chosen.id and not damage:
        return Provisioned(chosen.id, False, 0)
    far_side.check(far.obstacles(), name)
    check()
    with _turn(connection, show):
        return _made(connection, chosen, damage, show)


def _made(connection: HostConnection, chosen: WheelSet, damage: str, show: Progress) -> Provisioned:
    """Have a version on a host; only one command at a time does."""
    name, sent, fetched, unfetched = connection.host.name, 0, 0, ""
    answer = _install(connection, chosen, damage, show)
    if wanted := connection.host.index and [each for each in answer.lacking if each != chosen.own]:
        unfetched = _fetch(connection, chosen, wanted, answer.wheels, show)
        answer = _install(connection, chosen, damage, show)
        fetched = sum(os.path.getsize(chosen.files[e]) for e in {*wanted} - answer.lacking.keys())
    for _ in range(_TIMES):
        if not answer.lacking:
            break
        fault.point("provision.asked")
        sizes = {each: os.path.getsize(chosen.files[each]) for each in answer.lacking}
        there = {each: min(size, max(answer.lacking[each], 0)) for each, size in sizes.items()}
        sent += sum(sizes.values()) - sum(there.values())
        _send(connection, chosen, there, answer.wheels, show)
        fault.point("provision.sent")
        answer = _install(connection, chosen, damage, show)
    if answer.lacking:
        raise Refused(f"{name}: damaged on the way: {', '.join(answer.lacking)}")
    for each in answer.removed:
        show(name, HostStep(f"rtkit {each} is removed, nothing uses it"))
    return Provisioned(chosen.id, answer.made, sent, damage, fetched, unfetched)


@contextmanager
def _turn(connection: HostConnection, show: Progress) -> Iterator[None]:
    """Have no other command send to the host while inside: both would write to one file.

    A program there holds a lock until its input ends, as it does when the connection breaks.
    """
    name = connection.host.name
    channel = connection.open([connection.host.python, "-u", "-c", _TURN, far_program.MARK])
    try:
        channel.settimeout(_SILENT_S)
        text = b""
        while far_program.answer_in(text) is None:
            data = channel.recv(1 << 12)
            text += data
            if not data or len(text) > _LONGEST:
                why = far_program.last_lines(text + channel.recv_stderr(_LONGEST))
                raise Refused(f"{name}: rtkit cannot be made there: {why}")
            if b"waiting" in data:
                show(name, HostStep("waiting for another command that sends there"))
        yield
    except TimeoutError as error:
        raise Unreachable(f"{name}: no answer in {_SILENT_S:g} s") from error
    finally:
        with suppress(EOFError, OSError):  # the connection may be broken, and its error counts
            channel.close()


def _chosen(host: Host, far: FarSide, show: Progress) -> WheelSet:
    """Return the wheels for a host; a missing one is told with its name before all else."""
    show(host.name, HostStep("choosing wheels"))
    with named(host.name):
        return wheels.wheels_for(far.kind, host.extras)


def _install(
    connection: HostConnection, chosen: WheelSet, damage: str, show: Progress
) -> _Installed:
    """Make the version there if all wheels are, else return which are lacking."""
    host = connection.host
    what = {"id": chosen.id, "wheels": chosen.digests, "is_damaged": bool(damage)}
    try:
        found = decode_text(_Installed, _run(connection, "far_install.py", what, show))
    except (Malformed, Refused) as error:
        raise type(error)(f"{host.name}: rtkit cannot be made there: {error}") from None
    if not chosen.files.keys() >= found.lacking.keys():
        raise Malformed(f"{host.name}: it lacks what is no wheel of rtkit")
    return found


def _fetch(
    connection: HostConnection, chosen: WheelSet, wanted: list[str], folder: str, show: Progress
) -> str:
    """Have the host fetch wheels from its index; return why it did not, by reason and package.

    It is not believed: who installs them compares them again, and what lacks then is sent.
    """
    name = connection.host.name
    sizes = {each: (chosen.digests[each], os.path.getsize(chosen.files[each])) for each in wanted}
    what = {"index": connection.host.index, "folder": folder, "wheels": sizes}
    try:
        failed = decode_text(dict[str, str], _run(connection, "far_fetch.py", what, show))
    except (Malformed, Refused, Unreachable) as error:
        failed = dict.fromkeys(wanted, str(error))
    packages: dict[str, list[str]] = {}
    for each in sorted(failed.keys() & {*wanted}):
        why = " ".join(failed[each].split())[:_REASON]
        packages.setdefault(why, []).append(each.split("-")[0])
    why = "; ".join(f"{_listed(each)}: {why}" for why, each in packages.items())
    if why:
        show(name, HostStep(f"not fetched there: {why}"))
    return why


def _listed(names: list[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def _run(connection: HostConnection, file: str, what: dict[str, Any], show: Progress) -> str:
    """Run a program there that takes long, and shows its steps; return its answer."""
    host = connection.host

    def show_step(line: str) -> None:
        word, *rest = line.split()[:4] or [""]
        if word in _STEPS and len(rest) == 3 and rest[0].isdigit() and rest[1].isdigit():
            show(host.name, HostStep(word, int(rest[0]), int(rest[1]), "wheels"))
        elif word == "waiting":
            show(host.name, HostStep("waiting for another command that installs there"))

    command = [host.python, "-", json.dumps({**what, "mark": far_program.MARK})]
    program = far_program.text_of(file)
    return far_program.ask(connection, command, program, timeout_s=_SILENT_S, on_line=show_step)


def _send(
    connection: HostConnection,
    chosen: WheelSet,
    there: dict[str, int],
    folder: str,
    show: Progress,
) -> None:
    """Send files behind what is `there` of each [bytes]; each is in its place when it is whole.

    Raises:
        Unreachable: It was broken off.
        Refused: They cannot be written there.
    """
    from rtkit.hosts.ssh_library import paramiko

    name, at = connection.host.name, 0
    total = sum(os.path.getsize(chosen.files[each]) for each in there)
    draft = folder
    try:
        with quiet_sftp.open_sftp(connection, _SILENT_S) as files:
            for each, begin in there.items():
                draft = posixpath.join(folder, f"{each}.part")
                with open(chosen.files[each], "rb") as near, files.open(draft, "ab") as far:
                    far.set_pipelined(True)
                    near.seek(begin)
                    at += begin
                    while data := near.read(_CHUNK):
                        far.write(data)
                        at += len(data)
                        show(name, HostStep("sending", at, total, "MB"))
                files.posix_rename(draft, posixpath.join(folder, each))
                fault.point("provision.wheel")
    except (paramiko.SSHException, EOFError, ConnectionError, TimeoutError) as error:
        raise Unreachable(f"{name}: broken off at {posixpath.basename(draft)}") from error
    except OSError as error:
        if "closed" in str(error):
            raise Unreachable(f"{name}: broken off at {posixpath.basename(draft)}") from error
        why = error.strerror or str(error)
        raise Refused(f"{name}: cannot write {draft}: {why}") from error
