"""Reads system profiles, and locates their faults by line."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtkit.errors import InvalidDocument
from rtkit.fast_dataclass import dataclass

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.profile.parameters import SystemParameters
    from rtkit.profile.parameters.reading import SystemReading
    from rtkit.profile.rts_model import RtsProfile


@dataclass(frozen=True, slots=True)
class SystemDocument:
    """A system profile, and the text that it was read from.

    Attributes:
        source: Names it in messages.
        form: As was said; None if name and content tell it.
        resolved: Knows where its parts stand, if it had parameters; `data` has none of them.
    """

    profile: RtsProfile
    data: bytes
    source: str
    form: str | None
    resolved: SystemReading | None = None

    @contextmanager
    def naming(self) -> Iterator[None]:
        """Name the file, and the line of the component, in what is found wrong with the profile.

        Raises:
            InvalidDocument: What was raised inside.
        """
        from rtkit.deployment.system import BadComponent

        try:
            yield
        except BadComponent as error:
            raise InvalidDocument(f"{self._place(error.position)}: {error}") from error
        except InvalidDocument as error:
            raise InvalidDocument(f"{self.source}: {error}") from error

    def _place(self, position: int) -> str:
        """Return file and line in which the component at a position begins."""
        if self.resolved is not None:
            at = self.resolved.position((("components", position),), "")
            return f"{at.file}:{at.line}"
        from rtkit.profile.read import as_it_stands
        from rtkit.profile.xmlnames import clark

        root: Any = as_it_stands(self.data, self.source, self.form, "rts")[0]
        found = root.findall(clark("rts:Components"))
        element = found[position] if position < len(found) else root
        return f"{self.source}:{element.sourceline or 1}"


def is_saved_plan(data: bytes) -> bool:
    """Return whether a file begins as a saved plan does."""
    return re.match(rb'\s*\{\s*"schema"\s*:\s*"rtkit\.saved-plan/', data) is not None


def parse_document(
    session: Session,
    source: str,
    data: bytes,
    form: str | None = None,
    parameters: SystemParameters | None = None,
) -> SystemDocument:
    """Read a system profile, with values for its parameters; tell repairs when verbose.

    Raises:
        InvalidDocument: It is no system profile, or its parameters make no sense.
        UsageProblem: A value is for nothing.
    """
    from rtkit.profile import read
    from rtkit.profile.forms import has_parameters

    if is_saved_plan(data):
        raise InvalidDocument(f"{source}: is a saved plan; only rtapply takes it")
    if parameters is not None or has_parameters(data):
        found = read_parametrised(session, source, data, form, parameters)
        return SystemDocument(found.profile, found.data, source, found.form, found)
    reading = read.read_rts(data, source, form=form, strict=session.is_strict)
    for note in reading.notes:
        session.verbose(f"{source}:{note.line}: {note.text}")
    return SystemDocument(reading.profile, data, source, form)


def read_parametrised(
    session: Session,
    source: str,
    data: bytes,
    form: str | None,
    parameters: SystemParameters | None,
) -> SystemReading:
    """Read a system profile that may have parameters; tell repairs when verbose.

    Raises:
        InvalidDocument: It is no system profile, or its parameters make no sense.
        UsageProblem: A value is for nothing.
    """
    from rtkit.api.component_profiles import SEARCH_PATH
    from rtkit.profile.parameters.reading import read_system

    folders = os.environ.get(SEARCH_PATH, "").split(os.pathsep)
    strict = session.is_strict
    found = read_system(data, source, parameters, form=form, strict=strict, folders=folders)
    for file, note in found.notes:
        session.verbose(f"{file}:{note.line}: {note.text}")
    return found
