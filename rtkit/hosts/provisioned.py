"""The rtkit of another host: made there when it is missing, and how it is started.

It is a virtual environment in the user's own folder, ``~/.local/share/rtkit/versions/ID``, with a
link ``current`` to the one in use.
"""

from __future__ import annotations

import json
import os
import posixpath
from collections.abc import Callable, Iterable
from typing import NamedTuple

from rtkit.errors import Malformed, Refused, Unreachable
from rtkit.fast_dataclass import Record
from rtkit.hosts import far_side, wheels
from rtkit.hosts.connection import HostConnection
from rtkit.hosts.far_side import HostLook
from rtkit.hosts.wheels import WheelSet
from rtkit.rtc.serde import decode_text

_CURRENT = ".local/share/rtkit/current"
_INSTALL_S = 300.0
Notify = Callable[[str], object]


class Provisioned(NamedTuple):
    """Outcome of provisioning: the version in use, whether it is new, bytes that were sent."""

    id: str
    is_new: bool
    sent_bytes: int


class _Installed(Record):
    """Answer of `rtkit.hosts.far_install`: its folder of wheels, and which are lacking there."""

    wheels: str
    lacking: tuple[str, ...]
    made: bool


def python(connection: HostConnection) -> list[str]:
    """Return the words that run the Python of the rtkit of a host, with its name in the tree."""
    host = connection.host
    # A shell expands no ~ in words: what is run there begins in the user's home.
    return ["env", f"RTKIT_HOSTNAME={host.name}", f"{_CURRENT}/bin/python", "-P"]


def provision(connection: HostConnection, look: HostLook, notify: Notify) -> Provisioned:
    """Have this rtkit on a host; what is there already is used.

    Interrupted anywhere it can be done again: a version counts when it is complete.

    Raises:
        Refused: The host does not do; tells all that is wrong.
        NotFound: There is no wheel of something for it.
        Unreachable: The connection ended.
    """
    name = connection.host.name
    far_side.check(look.far, name)
    chosen = wheels.wheels_for(look.far.kind)
    if look.far.current == chosen.id:
        return Provisioned(chosen.id, False, 0)
    answer = _install(connection, chosen)
    sent = 0
    if answer.lacking:
        sent = sum(os.path.getsize(chosen.files[each]) for each in answer.lacking)
        notify(f"{name}: {len(answer.lacking)} wheels are sent, {sent / 1e6:.1f} MB")
        _send(connection, chosen, answer.lacking, answer.wheels)
        answer = _install(connection, chosen)
        if answer.lacking:
            raise Refused(f"{name}: damaged on the way: {', '.join(answer.lacking)}")
    notify(f"{name}: rtkit {chosen.id} is in use")
    return Provisioned(chosen.id, answer.made, sent)


def _install(connection: HostConnection, chosen: WheelSet) -> _Installed:
    """Make the version there if all wheels are, else return which are lacking.

    Raises:
        Refused: It cannot be made.
        Malformed: What that host answers makes no sense.
    """
    host = connection.host
    wanted = json.dumps({"id": chosen.id, "wheels": chosen.digests})
    done = connection.run(
        [host.python, "-", wanted], far_side.program("far_install.py"), timeout_s=_INSTALL_S
    )
    if done.status:
        lines = done.err.strip().splitlines() or [f"exit status {done.status}"]
        raise Refused(f"{host.name}: rtkit cannot be made there: {lines[-1]}")
    found = decode_text(_Installed, done.out)
    if not chosen.files.keys() >= {*found.lacking}:
        raise Malformed(f"{host.name}: it lacks what is no wheel of rtkit")
    return found


def _send(connection: HostConnection, chosen: WheelSet, names: Iterable[str], folder: str) -> None:
    """Send files; each is in its place when it is whole.

    Raises:
        Unreachable: It was broken off.
        Refused: They cannot be written there.
    """
    import paramiko

    with connection.sftp() as files:
        for name in names:
            draft = posixpath.join(folder, f"{name}.part")
            try:
                files.put(chosen.files[name], draft, confirm=True)
                files.posix_rename(draft, posixpath.join(folder, name))
            except (paramiko.SSHException, EOFError, ConnectionError) as error:
                raise Unreachable(f"{connection.host.name}: broken off at {name}") from error
            except OSError as error:
                why = error.strerror or str(error)
                raise Refused(f"{connection.host.name}: cannot write {draft}: {why}") from error
