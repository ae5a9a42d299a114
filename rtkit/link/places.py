"""Paths of sockets, locks and logs on this host; keeps other users out of their folders."""

from __future__ import annotations

import contextlib
import errno
import os
import stat

from rtkit.errors import Refused

DEFAULT_MANAGER = "manager"
INVENTORY = "hosts.toml"
"""Name of the files that name other hosts (`rtkit.hosts.inventory`)."""
"""Name of the manager that is asked when none is named."""

_MAX_SOCKET_PATH = 107
_MAX_FILE_NAME = 240
_NOT_IN_ENDPOINTS = '#?"\\'
_USED_BY_OTHERS = 0o077
_WRITTEN_BY_OTHERS = 0o022
_claimed: set[str] = set()
"""Managers whose lock this process has: the lock would go with any descriptor that is closed."""
_hosts: dict[str, str] = {}
"""Names of this host by the file that told them, which is asked for thousands of paths."""

_LOCK = "hhqqi"
"""``struct flock`` of Linux on 64 bits: type, whence, start, length, pid."""


def usual_manager() -> str:
    """Return the manager that is meant where none is named: its name, or its address."""
    return os.environ.get("RTKIT_MANAGER") or DEFAULT_MANAGER


def host_name() -> str:
    """Return the name of this host in the tree.

    That is ``RTKIT_HOSTNAME``, else the one that the usual manager has here: another host may have
    started it under a name of its own. Else it is that of the machine.
    """
    return os.environ.get("RTKIT_HOSTNAME") or _host_of_manager() or os.uname().nodename


def _host_of_manager() -> str:
    manager = usual_manager()
    path = os.path.join(runtime_path(), f"{manager}.lock")
    if path in _hosts or is_claimed(manager):  # whose lock would go with the descriptor
        return _hosts.get(path, "")
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError as error:
        if error.errno in (errno.EMFILE, errno.ENFILE):  # another name would be a wrong one
            raise Refused(f"cannot read {path}: {error.strerror}") from None
        return ""
    try:
        is_ours = os.fstat(descriptor).st_uid == os.getuid()
        found = os.read(descriptor, _MAX_FILE_NAME).decode("ascii", "replace") if is_ours else ""
    finally:
        os.close(descriptor)
    if found:
        _hosts[path] = found
    return found


def runtime_dir() -> str:
    """Return the folder of sockets and locks, in which nobody else can have laid one.

    Raises:
        Refused: It belongs to another user, or others may write in it.
    """
    return check_trusted(runtime_path())


def runtime_path() -> str:
    """Return where the folder of sockets and locks is, to make it or to say what is wrong with it.

    That is ``RTKIT_RUNTIME_DIR``, below the one of XDG, or below ``/tmp``.
    """
    chosen = os.environ.get("RTKIT_RUNTIME_DIR")
    if chosen:
        return os.path.abspath(chosen)
    base = os.environ.get("XDG_RUNTIME_DIR")
    return os.path.join(base, "rtkit") if base else f"/tmp/rtkit-{os.getuid()}"


def keep_runtime_folder() -> None:
    """Have the folder of sockets where it stays when the user logs out, from now on.

    systemd removes the user's runtime folder then, unless the user lingers.
    """
    import pwd

    user = pwd.getpwuid(os.getuid()).pw_name
    if not os.path.exists(f"/var/lib/systemd/linger/{user}"):
        os.environ.pop("XDG_RUNTIME_DIR", None)


def state_dir() -> str:
    """Return the folder of logs: ``RTKIT_STATE_DIR``, or below the XDG state folder.

    Where that cannot be written, as in a home that is read-only, it is beside the sockets.
    """
    chosen = os.environ.get("RTKIT_STATE_DIR")
    if chosen:
        return os.path.abspath(chosen)
    usual = usual_state_dir()
    return usual if _can_be_written(usual) else runtime_path() + ".state"


def usual_state_dir() -> str:
    """Return the folder of logs of a user who chose none and has a home that can be written."""
    base = os.environ.get("XDG_STATE_HOME") or os.path.expanduser("~/.local/state")
    return os.path.join(base, "rtkit")


def _can_be_written(path: str) -> bool:
    """Return whether files can be made in a folder, or it can be made itself."""
    while not os.path.lexists(path):
        path = os.path.dirname(path) or "/"
    return os.access(path, os.W_OK | os.X_OK)


def manager_socket(manager: str) -> str:
    """Return the path of a manager's socket."""
    return os.path.join(runtime_dir(), f"{manager}.sock")


def manager_lock(manager: str) -> str:
    """Return the path of the file whose lock makes a manager the only one of its name."""
    return os.path.join(runtime_dir(), f"{manager}.lock")


def control_socket(manager: str) -> str:
    """Return the path of the socket on which slaves report to their manager."""
    return os.path.join(runtime_dir(), f"{manager}.ctl")


def request_socket(manager: str) -> str:
    """Return the path of the socket on which a manager takes requests of commands."""
    return os.path.join(runtime_dir(), f"{manager}.req")


def sockets_of(manager: str) -> tuple[str, ...]:
    """Return the paths of all sockets on which a manager listens."""
    return manager_socket(manager), control_socket(manager), request_socket(manager)


def service_socket(service: str) -> str:
    """Return the path of the socket on which a property service speaks the line protocol."""
    return os.path.join(runtime_dir(), f"{_escaped(service)}.ps")


def service_key_socket(service: str) -> str:
    """Return the path of the socket on which a property service answers zenoh queries."""
    return os.path.join(runtime_dir(), f"{_escaped(service)}.zps")


def services() -> list[str]:
    """Return the names of the property services that have a socket, whether or not they live."""
    try:
        entries = os.listdir(runtime_dir())
    except OSError:
        return []
    return sorted(service_of(entry) for entry in entries if entry.endswith(".ps"))


def service_of(path: str) -> str:
    """Return the name of the property service that listens at a `service_socket`."""
    return os.path.basename(path).removesuffix(".ps").replace("%2F", "/")


def services_of(path: str) -> list[str]:
    """Return those of `services` whose names a path begins with, its host before it or not."""
    folder = runtime_dir()
    found: set[str] = set()
    steps = [step for step in path.split("/") if step not in ("", ".")]
    for rest in ("/".join(steps), "/".join(steps[1:])):
        ends = [at for at, character in enumerate(rest) if character in "./"]
        found.update(rest[:end] for end in (*ends, len(rest)))
    return sorted(name for name in found if os.path.exists(f"{folder}/{_escaped(name)}.ps"))


def _escaped(service: str) -> str:
    return service.replace("/", "%2F")


def data_socket(manager: str, pid: int) -> str:
    """Return the path of the socket on which a process takes data for its in ports."""
    return os.path.join(runtime_dir(), f"{manager}.{pid}.data")


def zygote_pattern(manager: str) -> str:
    """Return the path at which those listen that forked the slaves, ``%p`` for their pid."""
    return os.path.join(runtime_dir(), f"{manager}.%p.zygote")


def of_pid(pattern: str, pid: int | str) -> str:
    """Return the path that a pattern stands for; a manager named ``%p`` keeps its name."""
    before, found, after = pattern.rpartition("%p")
    return f"{before}{pid}{after}" if found else pattern


def log_file(manager: str, slave: str = "", folder: str = "") -> str:
    """Return the path of a manager's log, or of the log of a slave of it."""
    return f"{folder or state_dir()}/{_of_process(manager, slave)}.log"


def output_file(manager: str, slave: str = "", folder: str = "") -> str:
    """Return the path of what a process writes past its log, as plain text."""
    return f"{folder or state_dir()}/{_of_process(manager, slave)}.out"


def store_file(manager: str) -> str:
    """Return the path of the store in which a manager keeps the state that its users desire."""
    return f"{state_dir()}/{_of_process(manager, '')}.desired"


def former_store_file(path: str) -> str:
    """Return the path under which rtkit before 0.2 kept the store that is at a path now."""
    return f"{path.removesuffix('.desired')}.wishes"


def dump_file(manager: str) -> str:
    """Return the path of the dumps of a manager's own faults, ``%d`` for their number."""
    return f"{state_dir()}/{_of_process(manager, '')}".replace("%", "%%") + ".fault-%d.dump"


def _of_process(manager: str, slave: str) -> str:
    name = (f"{manager}.{slave}" if slave else manager).encode("utf-8", "surrogateescape")
    if len(name) > _MAX_FILE_NAME:
        import zlib

        name = name[: _MAX_FILE_NAME - 9] + b"~%08x" % zlib.crc32(name)
    return name.decode("utf-8", "surrogateescape")


def make_private(path: str) -> str:
    """Make the folder `path` for this user alone, or check that it is so, and return it.

    Raises:
        Refused: It cannot be made, is not ours, or is open to others.
    """
    try:
        make_folders(path)
    except OSError as error:
        raise Refused(f"cannot use folder {path}: {error.strerror}{_elsewhere(path)}") from error
    return check_private(path)


def make_folders(path: str) -> None:
    """Make a folder and those above it that lack, for this user alone, whatever the umask.

    Raises:
        OSError: One cannot be made, or something else is there.
    """
    if os.path.isdir(path):
        return
    if above := os.path.dirname(os.path.abspath(path)):
        make_folders(above)
    try:
        os.mkdir(path, 0o700)
    except FileExistsError:
        if not os.path.isdir(path):
            raise


def check_private(path: str) -> str:
    """Return the folder `path` if it is for this user alone.

    Raises:
        Refused: It is no folder, is not ours, or is open to others; the message has a hint.
    """
    try:
        status = os.lstat(path)
    except OSError as error:
        raise Refused(f"cannot use folder {path}: {error.strerror}{_elsewhere(path)}") from error
    _check_folder(status, path)
    _check_ours(status, path)
    mode = _check_closed(status, path, _USED_BY_OTHERS)
    if mode & 0o300 != 0o300 or not os.access(path, os.W_OK | os.X_OK):
        raise Refused(f"no permission to write in folder: {path}{_closed(path)}")
    return path


def check_trusted(path: str) -> str:
    """Return the folder `path` if what lies in it is of this user, or if there is no such folder.

    Root may look at what others have, by choosing their folder.

    Raises:
        Refused: It is no folder, belongs to another user, or others may write in it.
    """
    if os.getuid() == 0 and os.environ.get("RTKIT_RUNTIME_DIR"):
        return path
    try:
        status = os.lstat(path)
    except OSError:
        return path
    _check_ours(status, path)
    _check_folder(status, path)
    _check_closed(status, path, _WRITTEN_BY_OTHERS)
    return path


def _check_ours(status: os.stat_result, path: str) -> None:
    if status.st_uid != os.getuid():
        raise Refused(f"folder belongs to another user: {path}{_elsewhere(path)}")


def _check_folder(status: os.stat_result, path: str) -> None:
    if not stat.S_ISDIR(status.st_mode):
        raise Refused(f"not a folder: {path}{_elsewhere(path)}")


def _check_closed(status: os.stat_result, path: str, others: int) -> int:
    """Return the mode of a folder if it gives other users none of these rights."""
    mode = status.st_mode & 0o777
    if mode & others:
        raise Refused(f"folder is open to other users (mode {mode:o}): {path}{_closed(path)}")
    return mode


def _closed(path: str) -> str:
    return f" (repair it with: chmod 700 {quoted(path)})"


def _elsewhere(path: str) -> str:
    variable = "RTKIT_STATE_DIR" if path == state_dir() else "RTKIT_RUNTIME_DIR"
    return f" (choose another one with {variable})"


def quoted(text: str) -> str:
    """Return `text` as a shell takes it for one word."""
    from shlex import quote

    return quote(text)


def owner(manager: str) -> int | None:
    """Return the pid of the process that is the manager of that name, None when none is.

    The kernel reports the holder of the lock; 0 means that it does not know the pid.
    """
    import fcntl
    import struct

    if is_claimed(manager):
        return os.getpid()
    try:
        descriptor = os.open(manager_lock(manager), os.O_RDWR | os.O_NOFOLLOW)
    except OSError:
        return None
    try:
        asked = struct.pack(_LOCK, fcntl.F_WRLCK, os.SEEK_SET, 0, 0, 0)
        kind, _, _, _, pid = struct.unpack(_LOCK, fcntl.fcntl(descriptor, fcntl.F_GETLK, asked))
    finally:
        os.close(descriptor)
    return None if kind == fcntl.F_UNLCK else int(pid)


def is_claimed(manager: str) -> bool:
    """Return whether this process itself is the manager of that name."""
    return manager in _claimed


def claim(manager: str, *, is_held: bool) -> None:
    """Note that this process has the lock of a manager of that name, or has it no longer."""
    (_claimed.add if is_held else _claimed.discard)(manager)


def check_socket_length(path: str) -> str:
    """Return `path` if kernel and transport take it as a socket's.

    Raises:
        Refused: It is too long, or has characters that end the address of an endpoint.
    """
    bad = sorted({c for c in path if c in _NOT_IN_ENDPOINTS})
    if bad:
        raise Refused(f"socket path has characters that are not allowed {bad}: {path}")
    if len(os.fsencode(path)) > _MAX_SOCKET_PATH:
        raise Refused(
            f"socket path is longer than {_MAX_SOCKET_PATH} bytes,"
            f" set RTKIT_RUNTIME_DIR to a shorter folder: {path}"
        )
    return path


def remove_socket(path: str) -> None:
    """Remove a socket and the lock file that zenoh lays beside it."""
    for name in (path, path + ".lock"):
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)
