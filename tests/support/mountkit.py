"""Mount namespace of a test, where a file system can be made small or full."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache


@cache
def missing() -> str:
    """Return why there can be none here, empty if there can."""
    if os.getuid():
        return "only root may have a mount namespace of its own"
    if not (shutil.which("unshare") and shutil.which("nsenter")):
        return "unshare or nsenter is not installed"
    done = subprocess.run(["unshare", "-m", "true"], capture_output=True, text=True, check=False)
    return f"no mount namespace can be had here: {done.stderr}" if done.returncode else ""


@contextmanager
def small(folder: str, options: str) -> Iterator[list[str]]:
    """Have a folder be a file system of these options, for what is started with this prefix."""
    script = f"mount -t tmpfs -o {options},mode=1777 tmpfs {folder} && echo made && exec sleep 600"
    command = ["unshare", "-m", "--propagation", "private", "sh", "-c", script]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as owner:
        try:
            assert owner.stdout is not None
            assert owner.stdout.readline() == "made\n"
            yield ["nsenter", "--mount", f"--target={owner.pid}", "--"]
        finally:
            owner.kill()
