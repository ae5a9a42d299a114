"""Chooses the wheels of a package and of all that it needs, by pip, and fetches them."""

from __future__ import annotations

import importlib.metadata
import json
import os
import re
import shutil
import tempfile
from typing import Any, NamedTuple
from urllib.parse import unquote, urldefrag, urlsplit

from packaging.requirements import InvalidRequirement, Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.packages.repository import Repositories
from rtkit.packages.tools import pip
from rtkit.packages.wheel import Wheel, named, read_wheel
from rtkit.packages.wheel_target import WheelTarget

_CONSTRAINT = "The user requested (constraint)"
"""How pip names what a target has."""


class Chosen(NamedTuple):
    """A wheel that pip has chosen; SHA-256 in hexadecimal, as its repository has it now."""

    name: str
    version: str
    url: str
    sha256: str

    @property
    def file(self) -> str:
        """The name of its file."""
        return unquote(urlsplit(self.url).path).rpartition("/")[2]  # also of an escaped slash


def requirement(text: str) -> Requirement:
    """Return ``NAME``, with constraints on its version as ``NAME>=1.2,<2``.

    Raises:
        Malformed: It is none.
    """
    try:
        found = Requirement(text)
    except InvalidRequirement as error:
        raise Malformed(
            f"not NAME or NAME==VERSION: {text} ({error.args[0].splitlines()[0]})"
        ) from None
    if found.url:
        raise Malformed(f"names a place, not a version: {text} (--repository names places)")
    return found


def resolve(
    wanted: Requirement, repositories: Repositories, target: WheelTarget | None = None
) -> list[Chosen]:
    """Return the wheel that is wanted, and those of all it needs that a Python has not.

    Args:
        wanted: The package.
        repositories: Where it is looked for.
        target: The host whose Python it is, None for the Python here.

    Raises:
        NotFound: No repository has one that fits; says which versions there are.
        Unreachable: A simple index does not answer.
        Refused: Packages need versions of a third that exclude each other; names them.
    """
    chosen = []
    for each in _reported(wanted, repositories, target):
        metadata, info = each["metadata"], each["download_info"]
        digest = info["archive_info"]["hashes"]["sha256"]
        name = canonicalize_name(metadata["name"])
        chosen.append(Chosen(name, metadata["version"], urldefrag(info["url"])[0], digest))
    if target is not None:
        chosen = [each for each in chosen if each.name not in target.has]
    own = canonicalize_name(wanted.name)
    if own not in [each.name for each in chosen]:
        raise Refused(f"{own} is part of this Python already (pip uninstall {own} removes it)")
    for each in chosen if target is None else ():
        _check_environment(own, each)
    return sorted(chosen, key=lambda each: each.name != own)


def _reported(
    wanted: Requirement, repositories: Repositories, target: WheelTarget | None
) -> list[Any]:
    """Return what pip reports that it would install.

    Pip evaluates environment markers for the Python here: what packages need only on the target is
    asked for besides, until nothing is lacking.
    """
    options = ["--only-binary=:all:", "--retries", "1", *repositories.pip_options()]
    asked = [str(wanted)]
    with tempfile.TemporaryDirectory(prefix="rtpkg-") as folder:
        report = os.path.join(folder, "report.json")
        if target is not None:
            options += target.pip_options(folder)
        while True:
            what = ("--dry-run", "--report", report)
            output, error = pip("install", *what, *options, "--", *asked)
            if error:
                raise _failure(wanted, f"{output}\n{error}", repositories, target)
            with open(report, encoding="utf-8") as file:
                items: list[Any] = json.load(file)["install"]
            more = {*target.lacking(items)} - {*asked} if target is not None else ()
            if not more:
                return items
            asked += sorted(more)


def _check_environment(own: str, chosen: Chosen) -> None:
    """Refuse a package that this Python has in another version: that one would be imported."""
    try:
        there = importlib.metadata.version(chosen.name)
    except importlib.metadata.PackageNotFoundError:
        return
    if Version(there) != Version(chosen.version):
        raise Refused(
            f"conflict: {own} needs {chosen.name} {chosen.version},"
            f" and the Python of rtkit has {chosen.name} {there}"
        )


def _failure(
    wanted: Requirement, text: str, repositories: Repositories, target: WheelTarget | None
) -> RtkitError:
    lines = [line.strip() for line in text.splitlines()]
    if "The conflict is caused by:" in lines:
        rest = lines[lines.index("The conflict is caused by:") + 1 :]
        causes = rest[: rest.index("")] if "" in rest else rest
        causes = [each.replace(_CONSTRAINT, "the rtkit there has") for each in causes]
        return Refused(f"conflict: {'; '.join(causes)}")
    if "connection broken by" in text:
        asked = ", or of ".join(repositories.indexes)
        return Unreachable(f"no answer of {asked}, asked for {wanted}")
    lacking = re.findall(r"satisfies the requirement (.*) \(from versions: (.*)\)", text)
    if lacking:
        name, versions = lacking[0]
        there = f"; there is {versions}" if versions != "none" else ""
        needs = re.findall(r"\(from (.*?)\)", name)
        by = f", which {', '.join(needs)} needs" if needs else ""
        kind = f" for {target.kind.name}" if target is not None else ""
        return NotFound(f"no repository has {name.partition(' (from')[0]}{kind}{by}{there}")
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    if errors[:1] == ["Exception:"]:
        raised = re.findall(r"^\w[\w.]*(?:Error|Exception)\b.*", text, re.MULTILINE)
        asked = ", or ".join(repositories.indexes) or "the repositories"
        why = f": {raised[-1].replace('MemoryError', 'it does not end')}" if raised else ""
        return Malformed(f"{wanted}: pip cannot read what {asked} has{why}")
    if damaged := re.findall(r"^Wheel '.*' located at (.*) is invalid", "\n".join(errors), re.M):
        return Refused(f"{damaged[0]} is no wheel, or damaged{_cure(damaged[0])}")
    return Refused(f"{wanted}: {errors[0] if errors else lines[-1]}")


def _cure(file: str) -> str:
    """Return what is to be done about a wheel that cannot be used, which hides older ones."""
    try:
        name, version = named(file.rpartition("/")[2])
    except Malformed:
        return ""
    return f" (until its repository has a good one, ask for another: '{name}!={version}')"


def fetch(chosen: Chosen, folder: str, target: WheelTarget | None = None) -> Wheel:
    """Fetch a wheel, which was chosen for `target`, into a folder, and return it.

    Raises:
        Refused: It is not what pip has chosen, or is not safe; says why.
    """
    parts = urlsplit(chosen.url)
    path = os.path.join(folder, chosen.file)
    if parts.scheme == "file":
        shutil.copyfile(unquote(parts.path), path)
    else:
        link = f"{chosen.url}#sha256={chosen.sha256}"
        kind = target.kind.pip_options() if target is not None else []
        words = ("-q", "--no-deps", "--no-index", *kind, "-d", folder)
        _, error = pip("download", *words, "--", link)
        if error:
            raise Refused(f"{chosen.file}: {error.splitlines()[-1]}")
    try:
        wheel = read_wheel(path)
    except RtkitError as error:
        raise type(error)(f"{error}{_cure(chosen.file)}") from None
    if wheel.sha256 != chosen.sha256:
        raise Refused(f"{chosen.file} has changed while it was fetched")
    return wheel
