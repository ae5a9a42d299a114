"""Check an installed wheel, run by its own interpreter from anywhere: commands, data, samples."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import entry_points

import rtkit
from rtkit.resources import resource

_BIN = os.path.dirname(sys.executable)


def main() -> int:
    """Look at everything that a wheel must carry; an assertion tells what is missing."""
    home = os.path.dirname(os.path.abspath(rtkit.__file__))
    assert "site-packages" in home, home
    for parts in (("schemas", "RtsProfile.xsd"), ("examples", "basic"), ("profiles", "systems")):
        assert resource(*parts).startswith(home), parts
    assert os.path.exists(os.path.join(home, "py.typed"))
    names = sorted(point.name for point in entry_points(group="console_scripts"))
    ours = [name for name in names if name.startswith("rt")]
    for name in ours:
        shown = subprocess.run(
            [os.path.join(_BIN, name), "--version"], capture_output=True, text=True, check=True
        )
        assert shown.stdout == f"rtkit {rtkit.__version__}\n", (name, shown)
    print(f"{len(ours)} commands answer, data found below {home}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
