"""Do what the README says first, as a newcomer would, and time it: to the first live value.

The steps are the lines of the README itself, from the installation into a virtual environment up to
the first ``rtprint``, run in a home that is empty. The exit status is 1 if it took longer than
three minutes, or nothing came. The package index must be reachable, so no test does it.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
BOUND_S = 180.0
_BLOCK = re.compile(r"^```sh\n(.*?)^```$\n*(?:```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)
_FIRST_VALUE = "rtprint "


class Step(NamedTuple):
    """A block of the README: what is typed, and what is shown for that."""

    typed: str
    shown: str


def steps(readme: str) -> list[Step]:
    """Return the blocks up to the one that prints a value.

    Raises:
        ValueError: None does.
    """
    found: list[Step] = []
    for match in _BLOCK.finditer(readme):
        found.append(Step(match[1], match[2] or ""))
        if _FIRST_VALUE in match[1]:
            return found
    raise ValueError("the README prints no value")


def main() -> int:
    """Do the steps, print how long each took."""
    todo = steps((ROOT / "README.md").read_text(encoding="utf-8"))
    kept = ("PATH", "LANG", "PIP_INDEX_URL", "PIP_CONFIG_FILE", "SSL_CERT_FILE", "RTKIT_PORT")
    environment = {key: os.environ[key] for key in kept if key in os.environ}
    mark = "echo -- $EPOCHREALTIME\n"
    script = "trap 'rtmgr stop || true' EXIT\n" + "".join(step.typed + mark for step in todo)
    with tempfile.TemporaryDirectory(prefix="rtkit-first-") as home:
        environment |= {"HOME": home, "XDG_RUNTIME_DIR": home}
        began = time.time()
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", script],
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            text=True,
            check=False,
        )
    return _report(todo, began, re.split(r"^-- ([\d.]+)\n", done.stdout, flags=re.MULTILINE))


def _report(todo: list[Step], began: float, parts: list[str]) -> int:
    """Print how long each step took, by its output and the moment at which it ended, in turn."""
    ended = list(zip(parts[::2], map(float, parts[1::2]), strict=False))
    for step, (shown, moment) in zip(todo, ended, strict=False):
        print(f"{moment - began:6.1f} s  {step.typed.splitlines()[-1]}")
        if step.shown and shown != step.shown:
            print(f"it printed {shown!r}, not {step.shown!r}")
            return 1
    if len(ended) < len(todo):
        print("a step failed")
        return 1
    took_s = ended[-1][1] - began
    print(f"first live value after {took_s:.1f} s, of {BOUND_S:.0f}")
    return 1 if took_s > BOUND_S else 0


if __name__ == "__main__":
    sys.exit(main())
