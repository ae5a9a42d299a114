"""Installs, lists and removes packages of its own host; run there over SSH, by its rtkit.

Its arguments are ``install|list|uninstall|remove [NAME…]``; to install it is given a bundle. It
writes the packages that it is about as JSON behind a mark. There is no pip where it runs.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence

from rtkit.errors import RtkitError
from rtkit.hosts.far_program import MARK
from rtkit.link import places
from rtkit.packages.bundle import SUFFIX, unpacked
from rtkit.packages.installed import Installed, install_wheels, installed, meant, remove
from rtkit.packages.resolving import requirement
from rtkit.packages.usage import check_unused
from rtkit.packages.wheel import named

_ANSWER_S = 10.0


def main() -> int:
    """Be the program."""
    word, *names = sys.argv[1:]
    places.keep_runtime_folder()
    try:
        found = {"install": _install, "list": _list}.get(word)
        packages = found() if found is not None else _remove(names, is_forced=word == "remove")
    except (RtkitError, OSError) as error:
        print(MARK + json.dumps({"error": str(error)}))
        return 1
    print(MARK + json.dumps({"packages": [each._asdict() for each in packages]}))
    return 0


def _install() -> Sequence[Installed]:
    with tempfile.NamedTemporaryFile(suffix=SUFFIX) as file:
        shutil.copyfileobj(sys.stdin.buffer, file, 1 << 20)
        file.flush()
        done = []
        with unpacked(file.name, may_be_unsigned=True) as found:
            for package, wheels in found.packages.items():
                own = package.partition("==")[0]
                files = sorted(wheels, key=lambda each: named(each)[0] != own)
                done.append(install_wheels([os.path.join(found.wheels, each) for each in files]))
        return done


def _list() -> Sequence[Installed]:
    return installed()


def _remove(names: Sequence[str], *, is_forced: bool) -> Sequence[Installed]:
    found = [each for name in names for each in meant(requirement(name))]
    for each in () if is_forced else found:
        check_unused(each, _ANSWER_S)
    for each in found:
        remove(each)
    return found


if __name__ == "__main__":
    sys.exit(main())
