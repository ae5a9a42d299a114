"""Checks saved sources before a system changes: whether they compile, and modules import."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts

_IMPORT_S = 60.0
"""How long the import of a module may take [s]."""
_IMPORT = """
import sys
from rtkit.errors import RtkitError
from rtkit.modules.loader import Loader
try:
    Loader([]).load(*sys.argv[1:])
except RtkitError as error:
    sys.exit(str(error))
"""


def syntax_errors(files: Iterable[str]) -> Iterator[str]:
    """Yield ``FILE:LINE: SyntaxError: text`` for each Python file that does not compile."""
    for file in files:
        try:
            with open(file, "rb") as stream, warnings.catch_warnings():
                warnings.simplefilter("ignore")
                compile(stream.read(), file, "exec", dont_inherit=True)
        except SyntaxError as error:
            yield f"{shown(file)}:{error.lineno or 1}: {type(error).__name__}: {error.msg}"
        except (OSError, ValueError) as error:
            yield f"{shown(file)}:1: {error}"


def shown(file: str) -> str:
    """Return a file as users of the working directory call it."""
    relative = os.path.relpath(file)
    return file if relative.startswith("..") else relative


def files_of(components: Iterable[ComponentFacts]) -> list[str]:
    """Return the files that components come from, each module before what it imports."""
    lines = (line for facts in components for line in facts.code.splitlines())
    return list(dict.fromkeys(line.partition(" ")[2] for line in lines))


def check_imports(modules: Iterable[tuple[str, str]]) -> None:
    """Import modules, each by file and init function, in a process of its own.

    Raises:
        Refused: One does not import, or its init function fails; says where.
    """
    for file, init in dict.fromkeys(modules):
        command = [sys.executable, "-c", _IMPORT, file, init]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=_IMPORT_S, check=False
            )
        except subprocess.TimeoutExpired:
            raise Refused(f"{shown(file)}: its import takes longer than {_IMPORT_S:g} s") from None
        if done.returncode:
            lines = done.stderr.strip().splitlines()
            raise Refused(lines[-1] if lines else f"{shown(file)}: exit status {done.returncode}")
