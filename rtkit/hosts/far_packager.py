"""Installs, lists and removes packages of its own host; run there over SSH, by its rtkit.

Its arguments are ``list``, ``install [SYSTEM]``, for which it is given a bundle, ``survey``, for
which a question, or ``uninstall|remove NAME…``. It writes a `PackageAnswer` behind a mark. There
is no pip where it runs.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence

from rtkit.errors import RtkitError
from rtkit.fast_dataclass import Record, field, replace
from rtkit.hosts.far_program import MARK
from rtkit.link import places
from rtkit.packages.bundle import SUFFIX, unpacked
from rtkit.packages.installed import (
    install_wheels,
    installed,
    kept_wheels,
    meant,
    remove,
)
from rtkit.packages.needing import survey
from rtkit.packages.records import Installed, Question, Survey
from rtkit.packages.resolving import requirement
from rtkit.packages.usage import check_unused
from rtkit.packages.wheel import named, read_wheel
from rtkit.rtc.serde import decode_text, encode_text

_ANSWER_S = 10.0


class Signed(Record):
    """Signature of a wheel, and the SHA-256 of the RECORD that it is of, in hexadecimal."""

    sha256: str
    signature: str


class PackageAnswer(Record):
    """Answer of the program: the packages that it is about, or why nothing was done.

    Attributes:
        made: Those that are new, ``NAME==VERSION``.
        signed: Of each wheel of a package that is there, by the same.
        survey: What was surveyed.
    """

    packages: tuple[Installed, ...] = ()
    made: tuple[str, ...] = ()
    signed: Mapping[str, tuple[Signed, ...]] = field(default_factory=dict)
    survey: Survey = Survey()
    error: str = ""


def main() -> int:
    """Be the program."""
    word, *names = sys.argv[1:]
    places.keep_runtime_folder()
    try:
        answer = _answer(word, names)
    except (RtkitError, OSError) as error:
        answer = PackageAnswer(error=str(error) or type(error).__name__)
    print(MARK + encode_text(answer))
    return 1 if answer.error else 0


def _answer(word: str, names: Sequence[str]) -> PackageAnswer:
    match word:
        case "install":
            before = {each.text for each in installed()}
            done = _install(*names[:1])
            return replace(_answered(done), made=tuple({e.text for e in done} - before))
        case "list":
            return _answered(tuple(installed()))
        case "survey":
            asked = decode_text(Question, sys.stdin.buffer.read().decode())
            return PackageAnswer(survey=survey(asked, _ANSWER_S))
    return PackageAnswer(_remove(names, is_forced=word == "remove"))


def _answered(found: tuple[Installed, ...]) -> PackageAnswer:
    return PackageAnswer(found, signed={each.text: _signed(each) for each in found})


def _install(system: str = "") -> tuple[Installed, ...]:
    with tempfile.NamedTemporaryFile(suffix=SUFFIX) as file:
        shutil.copyfileobj(sys.stdin.buffer, file, 1 << 20)
        file.flush()
        done = []
        with unpacked(file.name, may_be_unsigned=True) as found:
            for package, wheels in found.packages.items():
                own = package.partition("==")[0]
                files = sorted(wheels, key=lambda each: named(each)[0] != own)
                paths = [os.path.join(found.wheels, each) for each in files]
                done.append(install_wheels(paths, system))
        return tuple(done)


def _signed(package: Installed) -> tuple[Signed, ...]:
    """Return the signatures of wheels that are there as they were installed; else none."""
    try:
        wheels = [read_wheel(each) for each in kept_wheels(package)]
    except RtkitError:
        return ()
    return tuple(
        Signed(hashlib.sha256(each.record).hexdigest(), each.signature.decode("ascii", "replace"))
        for each in wheels
    )


def _remove(names: Sequence[str], *, is_forced: bool) -> tuple[Installed, ...]:
    found = tuple(each for name in names for each in meant(requirement(name)))
    for each in () if is_forced else found:
        check_unused(each, _ANSWER_S, places.host_name())
    for each in found:
        remove(each)
    return found


if __name__ == "__main__":
    sys.exit(main())
