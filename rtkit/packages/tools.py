"""Runs pip and git, which ask nobody; pip reads no configuration of the user unless told to."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile

from rtkit.errors import Refused

_LONGEST_S = 600.0
_PIP = """
import resource, runpy
_, most = resource.getrlimit(resource.RLIMIT_DATA)
size = 2 << 30
resource.setrlimit(resource.RLIMIT_DATA, (size if most < 0 else min(size, most), most))
runpy.run_module("pip", run_name="__main__", alter_sys=True)
"""
"""Pip reads a page of an index to its end, also where it has none: this bounds its memory."""


def pip(*words: str, is_isolated: bool = True) -> tuple[str, str]:
    """Run pip; return what it writes, and why it failed, or nothing.

    Raises:
        Refused: It cannot be run.
    """
    usual = ["--disable-pip-version-check", "--no-input", *(["--isolated"] if is_isolated else [])]
    out, error = _run([sys.executable, "-c", _PIP, words[0], *usual, *words[1:]])
    if "No module named pip" in error:
        raise Refused(f"{sys.executable} has no pip, which fetches packages (install it there)")
    return out, error


def git(*words: str, folder: str) -> None:
    """Run git in a folder.

    Raises:
        Refused: It fails; says why.
    """
    _, error = _run(["git", "-C", folder, "-c", "protocol.ext.allow=never", *words])
    if error:
        lines = error.splitlines()
        failures = [each for each in lines if each.startswith(("fatal:", "error:"))]
        raise Refused(f"git {words[0]}: {(failures or lines)[0]}")


def git_head(url: str) -> str:
    """Return the branch of a git repository that a clone would check out, ``refs/heads/main``.

    Raises:
        Refused: It cannot be asked.
    """
    out, error = _run(["git", "ls-remote", "--symref", "--", url, "HEAD"])
    if not error and not out.startswith("ref: "):
        with tempfile.TemporaryDirectory(prefix="rtpkg-") as folder:  # only a clone learns it then
            git("clone", "-q", "--", url, folder, folder=folder)
            out, error = _run(["git", "-C", folder, "symbolic-ref", "HEAD"])
            out = f"ref: {out}"
    if error:
        raise Refused(f"git ls-remote: {error}")
    return out.split()[1]


def is_git_empty(url: str) -> bool:
    """Return whether a git repository has no commit yet.

    Raises:
        Refused: It cannot be asked.
    """
    out, error = _run(["git", "ls-remote", "--", url])
    if error:
        raise Refused(f"git ls-remote: {error}")
    return not out


def _run(command: list[str]) -> tuple[str, str]:
    environment = {**os.environ, "GIT_TERMINAL_PROMPT": "0"}
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=_LONGEST_S,
            env=environment,
            stdin=subprocess.DEVNULL,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Refused(f"{command[0]} cannot be run: {error}") from error
    failure = done.stderr.strip() or f"exit status {done.returncode}"
    return done.stdout, failure if done.returncode else ""
