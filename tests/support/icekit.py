"""Ice for the tests: the Debian package's, where the virtual environment has none.

The package index has no zeroc-ice that fits this Python without building it; Debian's
python3-zeroc-ice lies outside of every virtual environment. Only its Ice files are linked into a
folder of its own, which is put on the path: nothing else of the system's Python is seen.
"""

from __future__ import annotations

import atexit
import importlib.util
import shutil
import sys
import tempfile
from pathlib import Path

_DEBIAN = Path("/usr/lib/python3/dist-packages")


def _linked() -> str:
    """Return a folder with Ice in it, empty if there is none or none is needed."""
    if importlib.util.find_spec("IcePy") is not None:
        return ""
    found = [_DEBIAN / "Ice", *_DEBIAN.glob(f"IcePy.cpython-{sys.version_info[0]}"
                                            f"{sys.version_info[1]}-*.so")]  # fmt: skip
    if len(found) < 2 or not found[0].is_dir():
        return ""
    folder = tempfile.mkdtemp(prefix="rtkit-ice")
    atexit.register(shutil.rmtree, folder)
    for each in found:
        (Path(folder) / each.name).symlink_to(each)
    return folder


FOLDER = _linked()
"""To be put on the path of other processes; empty if they need none."""
if FOLDER:
    sys.path.append(FOLDER)
IS_THERE = importlib.util.find_spec("IcePy") is not None
MISSING = "Ice is not there: apt-get install python3-zeroc-ice"
PORT = 0 if IS_THERE else None
"""Of a door for Ice: any free one, where there can be a door."""
