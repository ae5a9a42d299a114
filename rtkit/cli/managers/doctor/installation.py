"""Checks the installation, the environment and the limits of this process, asking nobody."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from functools import cache

from rtkit.cli.managers.doctor import ERROR, NOTE, OK, WARNING, Diagnosis
from rtkit.settings.layers import PREFIX

_ZENOH = ((1, 10), (2, 0))
_FEWEST_FILES = 1024
_VARIABLES = (
    "RTKIT_COMPLETION_TIMEOUT", "RTKIT_CWD", "RTKIT_ENDS_WITH", "RTKIT_EXIT_DETAIL", "RTKIT_FAULT",
    "RTKIT_HOSTNAME", "RTKIT_KEYS", "RTKIT_MANAGER", "RTKIT_MANAGER_PROCESS", "RTKIT_MODULE_PATH",
    "RTKIT_MQTT_PASSWORD", "RTKIT_PORT", "RTKIT_PROFILE_PATH", "RTKIT_READY", "RTKIT_REALM",
    "RTKIT_REPOSITORIES", "RTKIT_RUNTIME_DIR", "RTKIT_SERVERS", "RTKIT_SIGNED", "RTKIT_SLAVE",
    "RTKIT_SSH_CONFIG", "RTKIT_STARTED", "RTKIT_STATE_DIR", "RTKIT_TIMEOUT", "RTKIT_WANTED",
)  # fmt: skip
_FOLDER_LISTS = ("RTKIT_MODULE_PATH", "RTKIT_PROFILE_PATH")


def installation(environment: Mapping[str, str]) -> Iterator[Diagnosis]:
    """Look at versions, environment, limits and the clock."""
    yield from _versions()
    yield from _commands(environment)
    yield from variables(environment)
    yield from _limits()
    yield from clock(time.time(), os.stat(__file__).st_mtime)


def _versions() -> Iterator[Diagnosis]:
    from rtkit import __version__

    found = version_of("eclipse_zenoh", sys.path)
    if found is None:
        cure = "python -m pip install 'eclipse-zenoh>=1.10,<2'"
        yield Diagnosis("versions", ERROR, "the transport, eclipse-zenoh, is not installed", cure)
        return
    python = ".".join(map(str, sys.version_info[:3]))
    yield transport(found) or Diagnosis(
        "versions", OK, f"rtkit {__version__}, Python {python}, zenoh {found}"
    )


def version_of(distribution: str, folders: Iterable[str]) -> str | None:
    """Return the version of an installed package, by its name with underscores; None without it.

    The name of its folder has the version; `importlib.metadata`, which knows other installations,
    takes longer to import than all else here.
    """
    stem, end = f"{distribution}-", ".dist-info"
    for folder in folders:
        try:
            names = os.listdir(folder or os.curdir)
        except OSError:  # no folder, or an archive
            continue
        for name in names:
            if name.lower().startswith(stem) and name.endswith(end):
                return name[len(stem) : -len(end)]
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(distribution)
    except PackageNotFoundError:
        return None


def transport(version: str) -> Diagnosis | None:
    """Return the fault of a version of the transport, if it has any."""
    least, limit = _ZENOH
    parts = version.split(".")[:2]
    known = tuple(int(part) for part in parts if part.isdigit())
    if len(known) == 2 and least <= known < limit:
        return None
    cure = "python -m pip install 'eclipse-zenoh>=1.10,<2'"
    return Diagnosis("versions", ERROR, f"eclipse-zenoh is {version}, not 1.10 or later 1.x", cure)


def _commands(environment: Mapping[str, str]) -> Iterator[Diagnosis]:
    """Report commands on the shell's path that belong to another installation."""
    from shutil import which

    own = os.path.dirname(os.path.abspath(sys.executable))
    beside = os.path.join(own, "rtls")
    found = which("rtls", path=environment.get("PATH"))
    if found is None:
        cure = f"export PATH={own}:$PATH"
        yield Diagnosis("commands", WARNING, "the commands are not on PATH", cure)
    elif os.path.exists(beside) and not os.path.samefile(found, beside):
        text = f"rtls on PATH is that of another installation: {found}, not {beside}"
        cure = f"export PATH={own}:$PATH"
        yield Diagnosis("commands", WARNING, text, cure)
    else:
        yield Diagnosis("commands", OK, f"commands are those beside {own}")


def variables(environment: Mapping[str, str]) -> Iterator[Diagnosis]:
    """Look at the variables that mean something to rtkit, and at those that nearly do."""
    from rtkit.rtc.nearest import did_you_mean

    found = []
    for name in sorted(each for each in environment if each.startswith("RTKIT_")):
        known = (*_VARIABLES, *_of_options()) if name.startswith(f"{PREFIX}RT") else _VARIABLES
        hint = "" if name in known else did_you_mean(name, known)
        if hint:
            text = f"{name} means nothing to rtkit{hint}"
            found.append(Diagnosis("environment", WARNING, text, f"unset {name}", name))
    for name in _FOLDER_LISTS:
        for folder in filter(None, environment.get(name, "").split(os.pathsep)):
            if not os.path.isdir(folder):
                text = f"{name} names a folder that is not there: {folder}"
                cure = f"mkdir -p {folder}, or take it out of {name}"
                found.append(Diagnosis("environment", WARNING, text, cure, name))
    configuration = environment.get("RTC_MANAGER_CONFIG", "")
    if configuration and not os.access(configuration, os.R_OK):
        text = f"RTC_MANAGER_CONFIG names a file that cannot be read: {configuration}"
        cure = "unset RTC_MANAGER_CONFIG, or correct it; rtmgr start would fail"
        found.append(Diagnosis("environment", ERROR, text, cure, "RTC_MANAGER_CONFIG"))
    yield from found or [Diagnosis("environment", OK, "variables are in order")]


@cache
def _of_options() -> tuple[str, ...]:
    """Return the variables that stand for options; only made where there is one of that kind."""
    from rtkit.cli.shared.commands import TABLE, load
    from rtkit.cli.shared.defaults import settable, variable_of

    options = ((name, each) for name in TABLE for each in settable(load(name).command))
    return tuple(variable_of(f"{name} {option}") for name, option in options)


def _limits() -> Iterator[Diagnosis]:
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    yield files(soft, hard)


def files(soft: int, hard: int) -> Diagnosis:
    """Judge the limit on open files of a process."""
    if soft < 0 or soft >= _FEWEST_FILES:
        return Diagnosis("limits", OK, f"{soft} files may be open", "", "nofile")
    text = f"only {soft} files may be open: not enough for a manager of a hundred slaves"
    most = hard if 0 <= hard < 4096 else 4096
    return Diagnosis("limits", WARNING, text, f"ulimit -n {most}", "nofile")


def clock(now: float, installed: float) -> Iterator[Diagnosis]:
    """Judge the clock by when these files were installed [s since 1970]."""
    if now >= installed:
        yield Diagnosis("clock", OK, "the clock is later than this installation")
        return
    text = f"the clock is {installed - now:.0f} s before this installation: stamps will be wrong"
    yield Diagnosis("clock", ERROR, text, "timedatectl set-ntp true, or date -s to set it")


def shell(environment: Mapping[str, str], home: str) -> Diagnosis:
    """Check that the user's shell loads rtcwd and completion."""
    name = os.path.basename(environment.get("SHELL", ""))
    files = {
        "bash": (".bashrc", ".bash_profile"),
        "zsh": (".zshrc",),
        "fish": (".config/fish/config.fish",),
    }.get(name, ())
    for file in files:
        try:
            with open(os.path.join(home, file), encoding="utf-8", errors="replace") as stream:
                if "shell-init" in stream.read():
                    return Diagnosis("shell", OK, f"{name} knows rtcwd and completion")
        except OSError:
            continue
    if not files:
        return Diagnosis("shell", NOTE, "the shell is none of bash, zsh and fish")
    script = f"rtkit shell-init {name}"
    line = f"{script} | source" if name == "fish" else f'eval "$({script})"'
    text = f"~/{files[0]} does not load rtcwd and completion"
    return Diagnosis("shell", NOTE, text, f"add to it: {line}")
