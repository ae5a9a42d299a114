"""Target of wheels: the kind of a host that they are chosen for, and what its Python has."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

_NEWEST_GLIBC, _OLDEST_GLIBC = 45, 17


class WheelKind(NamedTuple):
    """Kind of host, as far as wheels go: ``3.11``, ``x86_64``, ``2.36``."""

    python: str
    machine: str
    glibc: str

    @property
    def name(self) -> str:
        """The name of the kind in folders and messages."""
        return f"cp{self.python.replace('.', '')}-glibc{self.glibc}-{self.machine}"

    def pip_options(self) -> list[str]:
        """Return the options of pip that choose wheels for this kind of host."""
        digits = self.python.replace(".", "")
        words = ["--only-binary=:all:", "--implementation", "cp", "--python-version", self.python]
        for abi in (f"cp{digits}", "abi3", "none"):
            words += ["--abi", abi]
        for platform in self.platforms:
            words += ["--platform", platform]
        return words

    @property
    def platforms(self) -> list[str]:
        """Platforms of wheels that do, the newest first."""
        newest = min(int(self.glibc.partition(".")[2] or _OLDEST_GLIBC), _NEWEST_GLIBC)
        minors = range(newest, _OLDEST_GLIBC - 1, -1)
        return [f"manylinux_2_{minor}_{self.machine}" for minor in minors] + [
            f"manylinux2014_{self.machine}"
        ]

    def fits(self, files: Iterable[str]) -> bool:
        """Return whether all of these wheels do for this kind of host."""
        from packaging.tags import compatible_tags, cpython_tags
        from packaging.utils import parse_wheel_filename

        digits = f"cp{self.python.replace('.', '')}"
        version = tuple(map(int, self.python.split(".")))
        tags = {
            *cpython_tags(version, [digits], self.platforms),
            *compatible_tags(version, digits, self.platforms),
        }
        names = (os.path.basename(each) for each in files)
        return not any(tags.isdisjoint(parse_wheel_filename(each)[3]) for each in names)


class WheelTarget(NamedTuple):
    """A host that wheels are chosen for.

    Attributes:
        kind: Of its Python and machine.
        has: Versions of what its Python has beside rtkit, and of rtkit, by canonical name.
    """

    kind: WheelKind
    has: Mapping[str, str]

    def pip_options(self, folder: str) -> list[str]:
        """Return the options of pip that choose what the target lacks.

        Args:
            folder: An empty one: it gets wheels without content, which stand for what is there.
        """
        for name, version in self.has.items():
            _write_empty(folder, name.replace("-", "_"), version)
        limits = os.path.join(folder, "constraints.txt")
        with open(limits, "w", encoding="utf-8") as file:
            file.writelines(f"{name}=={version}\n" for name, version in self.has.items())
        where = ["--target", os.path.join(folder, "target"), "--find-links", folder]
        return [*self.kind.pip_options(), *where, "--constraint", limits]

    def lacking(self, items: Iterable[Mapping[str, Any]]) -> Iterator[str]:
        """Yield what packages need on the target, that is not among them and not there.

        Args:
            items: The packages, as an installation report of pip tells them.
        """
        from packaging.requirements import Requirement
        from packaging.utils import canonicalize_name

        items = list(items)
        there = {canonicalize_name(each["metadata"]["name"]) for each in items} | self.has.keys()
        python, machine = self.kind.python, self.kind.machine
        environment = {"python_version": python, "python_full_version": f"{python}.0"}
        environment |= {"platform_machine": machine}
        for each in items:
            extras = ["", *each.get("requested_extras", ())]
            for needed in map(Requirement, each["metadata"].get("requires_dist", ())):
                marker, needed.marker = needed.marker, None
                is_needed = marker is None or any(
                    marker.evaluate({**environment, "extra": extra}) for extra in extras
                )
                if is_needed and canonicalize_name(needed.name) not in there:
                    yield str(needed)


def _write_empty(folder: str, name: str, version: str) -> None:
    info = f"{name}-{version}.dist-info"
    texts = {
        "METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        "WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        "RECORD": "",
    }
    path = os.path.join(folder, f"{name}-{version}-py3-none-any.whl")
    with zipfile.ZipFile(path, "w") as wheel:
        for each, text in texts.items():
            wheel.writestr(f"{info}/{each}", text)
