"""Reads system profiles, and locates their faults by line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtkit.errors import InvalidDocument
from rtkit.fast_dataclass import dataclass

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.profile.rts_model import RtsProfile


@dataclass(frozen=True, slots=True)
class SystemDocument:
    """A system profile, and the text that it was read from.

    Attributes:
        source: Names it in messages.
        form: As was said; None if name and content tell it.
    """

    profile: RtsProfile
    data: bytes
    source: str
    form: str | None

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
            where = f"{self.source}:{self._line(error.position)}"
            raise InvalidDocument(f"{where}: {error}") from error
        except InvalidDocument as error:
            raise InvalidDocument(f"{self.source}: {error}") from error

    def _line(self, position: int) -> int:
        """Return the line in which the component at a position begins."""
        from rtkit.profile.read import as_it_stands
        from rtkit.profile.xmlnames import clark

        root: Any = as_it_stands(self.data, self.source, self.form, "rts")[0]
        found = root.findall(clark("rts:Components"))
        element = found[position] if position < len(found) else root
        return int(element.sourceline or 1)


def is_saved_plan(data: bytes) -> bool:
    """Return whether a file begins as a saved plan does."""
    return re.match(rb'\s*\{\s*"schema"\s*:\s*"rtkit\.saved-plan/', data) is not None


def parse_document(
    session: Session, source: str, data: bytes, form: str | None = None
) -> SystemDocument:
    """Read a system profile; tell repairs when verbose.

    Raises:
        InvalidDocument: It is no system profile.
    """
    from rtkit.profile import read

    if is_saved_plan(data):
        raise InvalidDocument(f"{source}: is a saved plan; only rtapply takes it")
    reading = read.read_rts(data, source, form=form, strict=session.is_strict)
    for note in reading.notes:
        session.verbose(f"{source}:{note.line}: {note.text}")
    return SystemDocument(reading.profile, data, source, form)
