"""Builds the package of components that a folder is, and checks it."""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import tempfile
import tomllib

from packaging.requirements import InvalidRequirement, Requirement

from rtkit.errors import InvalidDocument, Malformed, NotFound, Refused
from rtkit.packages.tools import pip
from rtkit.packages.wheel import Wheel, objections, read_wheel

_FILE = "pyproject.toml"
_ignored = shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__")


def build(folder: str, output: str) -> Wheel:
    """Build the wheel of a folder with a ``pyproject.toml``, into a folder.

    Raises:
        NotFound: There is no such folder, or no ``pyproject.toml`` in it.
        Refused: pip cannot build it.
        InvalidDocument: A profile is not valid, or an entry point or type is not described;
            nothing is left then.
    """
    has_tools = _has_tools(folder)
    os.makedirs(output, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=output, prefix=".rtpkg-") as draft:
        # With the tools here no index is needed; else pip fetches them by the user's own settings.
        how = ["--no-build-isolation"] if has_tools else []
        source, made = os.path.join(draft, "source"), os.path.join(draft, "made")
        shutil.copytree(folder, source, symlinks=True, ignore=_ignored)  # tools leave things there
        _, error = pip("wheel", "-q", "--no-deps", *how, "-w", made, source, is_isolated=has_tools)
        if error:
            errors = [line for line in error.splitlines() if "rror" in line]
            raise Refused(f"{folder} does not build: {(errors or [error.splitlines()[-1]])[-1]}")
        (file,) = os.listdir(made)
        path = os.path.join(made, file)
        wheel = read_wheel(path)
        found = objections(wheel)
        if found:
            raise InvalidDocument(f"{folder} makes no package: {'; '.join(found)}")
        os.replace(path, os.path.join(output, file))
    return wheel


def _has_tools(folder: str) -> bool:
    """Return whether this Python has what the folder is built with.

    Raises:
        NotFound: There is no ``pyproject.toml``.
        Malformed: It cannot be read.
    """
    path = os.path.join(folder, _FILE)
    try:
        with open(path, "rb") as file:
            project = tomllib.load(file)
        wanted = [Requirement(each) for each in project["build-system"]["requires"]]
    except (FileNotFoundError, NotADirectoryError):
        raise NotFound(f"no {_FILE} in {folder} (rtnew and rtbuild write one)") from None
    except (tomllib.TOMLDecodeError, KeyError, TypeError, InvalidRequirement) as error:
        raise Malformed(f"{path}: {error}") from None
    try:
        return all(
            each.specifier.contains(importlib.metadata.version(each.name)) for each in wanted
        )
    except importlib.metadata.PackageNotFoundError:
        return False
