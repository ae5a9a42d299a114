"""``rtmgr install`` and ``uninstall``: a manager as a service of systemd."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.errors import NotFound, Refused
from rtkit.link import places
from rtkit.link.atomic import write_output
from rtkit.manager.unit_file import ROOT, ManagerService, is_as_written, unit_name

if TYPE_CHECKING:
    from rtkit.cli.managers.word_options import WordOptions

OF_MACHINE = "/etc/systemd/system"
_RUNNING = "/run/systemd/system"
_KEPT = ("RTKIT_REALM", "RTKIT_MODULE_PATH", "RTKIT_PROFILE_PATH", "RTKIT_PORT")
_KEPT_FOLDERS = ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR")
_KEPT_FILES = ("RTC_MANAGER_CONFIG",)


def install(
    app: App,
    name: str,
    wanted: tuple[str, tuple[str, ...], bool],
    options: WordOptions,
    *,
    shows: str,
) -> None:
    """Write the unit of a manager, or only show it; tell what starts it.

    `wanted` is its configuration file, properties over it, and whether the file may be missing;
    `shows` is ``text`` for the unit alone, ``json`` for a record of the file.

    Raises:
        Malformed: A word cannot be written.
        NotFound: There is no such user, or the unit cannot be written.
        Refused: There is a unit that somebody changed.
    """
    is_user = _is_user(options)
    service = _service(name, wanted, "" if is_user else _account(options.user))
    if shows == "text":
        terminal.write(service.text().splitlines())
        return
    path = _path(name, is_user)
    had = _check(path, options.is_forced, "replaces")
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)
    except OSError as error:
        raise NotFound(f"cannot write {path}: {error.strerror}") from error
    write_output(service.text().encode("utf-8", "surrogateescape"), path, mode=0o644)
    if shows == "json":
        terminal.write([json_records.line("built-file", json_records.written_file(path))])
    else:
        terminal.write([terminal.printable(path)])
    _report_next(app, service, is_new=had is None)


def uninstall(app: App, name: str, options: WordOptions) -> None:
    """Remove the unit of a manager, and the links by which it is enabled.

    Raises:
        NotFound: There is none, or it cannot be removed.
        Refused: Somebody changed it.
    """
    is_user = _is_user(options)
    path = _path(name, is_user)
    if _check(path, options.is_forced, "removes") is None:
        raise NotFound(f"manager {name!r} is not installed: no {path}")
    folder, unit = os.path.split(path)
    links = [
        os.path.join(folder, entry, unit)
        for entry in os.listdir(folder)
        if entry.endswith(".wants")
    ]
    try:
        for link in (*filter(os.path.islink, links), path):
            os.unlink(link)
    except OSError as error:
        raise NotFound(f"cannot remove {error.filename}: {error.strerror}") from error
    systemctl = _systemctl(is_user)
    if os.path.isdir(_RUNNING):
        app.fail(f"next: {systemctl} daemon-reload")
    if places.owner(name) is not None:
        app.fail(f"note: manager {name!r} still runs; rtmgr stop {places.quoted(name)} ends it")


def _is_user(options: WordOptions) -> bool:
    is_system = options.is_system or bool(options.user)
    return options.is_user or not (is_system or os.getuid() == 0)


def _account(typed: str) -> str:
    """Return whom a service of the machine runs as: who asked root for it, unless one is named."""
    import pwd

    name = typed or os.environ.get("SUDO_USER") or pwd.getpwuid(os.getuid()).pw_name
    try:
        return pwd.getpwnam(name).pw_name
    except KeyError as error:
        raise NotFound(f"no such user: {name}") from error


def _service(name: str, wanted: tuple[str, tuple[str, ...], bool], user: str) -> ManagerService:
    file, properties, is_lenient = wanted
    options = ["-f", os.path.abspath(file)] if file else []
    for each in properties:
        options += ["-o", each]
    program = os.path.join(os.path.dirname(sys.executable), "rtmgr")
    if not os.access(program, os.X_OK):
        raise NotFound(f"rtkit is not installed here: no program {program}")
    return ManagerService(
        name,
        [program],
        [*options, *(["-i"] if is_lenient else [])],
        os.getcwd(),
        _environment(is_user=not user),
        user,
        _version(),
    )


def _environment(*, is_user: bool) -> dict[str, str]:
    """Return the variables of this shell that say where a manager is and what it reads."""
    paths = (*(_KEPT_FOLDERS if is_user else ()), *_KEPT_FILES)
    kept = {name: os.environ[name] for name in (*paths, *_KEPT) if os.environ.get(name)}
    return {name: os.path.abspath(text) if name in paths else text for name, text in kept.items()}


def _version() -> int:
    """Return the version of systemd, 0 without it."""
    systemctl = shutil.which("systemctl")
    if systemctl is None:
        return 0
    done = subprocess.run([systemctl, "--version"], capture_output=True, text=True, check=False)
    words = done.stdout.split()
    with suppress(IndexError, ValueError):
        return int(words[1])
    return 0


def _path(name: str, is_user: bool) -> str:
    base = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")
    return os.path.join(f"{base}/systemd/user" if is_user else OF_MACHINE, unit_name(name))


def _check(path: str, is_forced: bool, done: str) -> str | None:
    """Return the text of a unit that is there, None without one.

    Raises:
        Refused: Somebody changed it, and this is not forced.
        NotFound: It cannot be read.
    """
    try:
        with open(path, encoding="utf-8", errors="surrogateescape") as file:
            text = file.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise NotFound(f"cannot read {path}: {error.strerror}") from error
    if not is_forced and not is_as_written(text):
        raise Refused(f"{path} was changed, or not written by rtmgr; --force {done} it")
    return text


def _systemctl(is_user: bool) -> str:
    return "systemctl --user" if is_user else "systemctl"


def _report_next(app: App, service: ManagerService, *, is_new: bool) -> None:
    """Tell what makes a service of a unit that was written."""
    is_user = not service.user
    unit = places.quoted(unit_name(service.name))
    if not os.path.isdir(_RUNNING):
        app.fail("note: systemd does not run here, so nothing reads this; rtmgr start does without")
        return
    systemctl = _systemctl(is_user)
    if is_new:
        app.fail(f"next: {systemctl} enable --now {unit}")
    else:
        app.fail(f"next: {systemctl} daemon-reload && {systemctl} restart {unit}")
    if is_user:
        app.fail("note: loginctl enable-linger has it run also while you are not logged in")
    else:
        for variable, folder in (
            ("RTKIT_RUNTIME_DIR", service.runtime_folder),
            ("RTKIT_STATE_DIR", service.state_folder),
        ):
            app.fail(f"note: commands of {service.user} find it by export {variable}={folder}")
    if service.user == ROOT:
        app.fail("warning: it runs as root, and so do all components; --run-as names another user")
