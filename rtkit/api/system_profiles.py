"""System profiles: read, with faults located by line; validated, checked and written."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from rtkit.errors import InvalidDocument, UsageProblem
from rtkit.fast_dataclass import dataclass, field, replace

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.profile.parameters import SystemParameters
    from rtkit.profile.parameters.reading import SystemReading
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.report.finding import Checked


@dataclass(frozen=True, slots=True)
class SystemProfile:
    """A system profile (RTS profile): components, connections, parameters of a system.

    Example::

        robot = rtkit.load("robot.xml")
        for finding in robot.check().findings:
            print(finding.line, finding.text)
        robot.write("robot.yaml")

    Attributes:
        profile: Its content, as data of `rtkit.profile.rts_model`.
        data: The text that it was read from.
        source: Names it in messages, as a rule the file.
        form: ``xml``, ``yaml`` or ``json`` if that was said; None if name and content tell it.
        resolved: Knows where its parts stand, if it had parameters; `data` has none of them.
        mapped: Its hosts for which another one stands, with that one.
    """

    profile: RtsProfile
    data: bytes
    source: str
    form: str | None
    resolved: SystemReading | None = None
    mapped: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<SystemProfile {self.source}: {len(self.profile.components)} components>"

    @property
    def components(self) -> list[str]:
        """The instance names of its components."""
        return [each.instance_name for each in self.profile.components]

    def validate(self, *, strict: bool = False) -> Checked:
        """Return the verdict of the schemas, with a finding for each repair.

        Args:
            strict: Take every repair for an error.
        """
        from rtkit.profile_tools.validation import validated

        return validated(self.data, self.source, form=self.form, strict=strict)

    def check(self, components: Sequence[str] = (), *, strict: bool = False) -> Checked:
        """Return the verdict of the static check: nothing that lives is asked.

        Args:
            components: Files and folders with RTC profiles of component types.
            strict: Take warnings for errors.

        Raises:
            NotFound: A file or folder of components cannot be read.
        """
        from rtkit.api.component_profiles import profiles
        from rtkit.manager.limits.control_groups import capacity
        from rtkit.static_check.stock import CandidateDocument, stocked
        from rtkit.static_check.verdict import Options, opened, verdict

        options = Options(strict, (), capacity)
        system = opened(self.data, self.source, form=self.form, strict=strict)
        files = [self.source] if os.path.exists(self.source) else []
        found = profiles(components, lambda _: None, systems=files)
        catalogue, _ = stocked((CandidateDocument(*each) for each in found), system.types, options)
        return verdict(system, catalogue, options)

    def text(self, form: str = "xml") -> str:
        """Return it as XML, YAML or JSON."""
        from rtkit.profile.write import write_profile

        return write_profile(self.profile, form).decode()

    def write(self, path: str | os.PathLike[str], form: str = "") -> None:
        """Write it to a file in one step, in the form that the name of the file ends with.

        Raises:
            NotFound: It cannot be written; what was there is unchanged.
        """
        from rtkit.link.atomic import write_output
        from rtkit.profile.forms import form_of_name

        name = os.fspath(path)
        write_output(self.text(form or form_of_name(name) or "xml").encode(), name)

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


BUNDLE = ".rtbundle"
"""Ending of the names of bundles, which hold a system profile and its packages."""
Source = SystemProfile | str | os.PathLike[str]
"""A system profile, or the path of its file: XML, YAML or JSON."""


def is_saved_plan(data: bytes) -> bool:
    """Return whether a file begins as a saved plan does."""
    return re.match(rb'\s*\{\s*"schema"\s*:\s*"rtkit\.saved-plan/', data) is not None


def parse_document(
    session: Session,
    source: str,
    data: bytes,
    form: str | None = None,
    parameters: SystemParameters | None = None,
) -> SystemProfile:
    """Read a system profile, with values for its parameters; tell repairs when verbose.

    An inventory of hosts beside its file, ``hosts.toml``, counts in this process from now on.

    Raises:
        InvalidDocument: It is no system profile, or its parameters make no sense.
        UsageProblem: A value is for nothing.
    """
    from rtkit.profile import read
    from rtkit.profile.forms import has_parameters

    if is_saved_plan(data):
        raise InvalidDocument(f"{source}: is a saved plan; only rtapply takes it")
    _heed_inventory(source)
    if parameters is not None or has_parameters(data):
        found = read_parametrised(session, source, data, form, parameters)
        return SystemProfile(found.profile, found.data, source, found.form, found)
    reading = read.read_rts(data, source, form=form, strict=session.is_strict)
    for note in reading.notes:
        session.verbose(f"{source}:{note.line}: {note.text}")
    return SystemProfile(reading.profile, data, source, form)


def _heed_inventory(source: str) -> None:
    """Have an inventory of hosts beside the file of a profile count; few profiles have one."""
    from rtkit.link.places import INVENTORY

    folder = os.path.dirname(source)
    if folder and os.path.lexists(os.path.join(folder, INVENTORY)):
        from rtkit.settings import inventory_files

        inventory_files.heed(folder)


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


def load(
    source: Source,
    *,
    values: Mapping[str, object] | None = None,
    prefix: str = "",
    form: str | None = None,
    strict: bool = False,
) -> SystemProfile:
    """Load a system profile from a file: ``rtkit.load("robot.xml", values={"wall": 3})``.

    Args:
        source: Path of the file.
        values: Of its variables, and of parameters: ``{"Camera0.noise": 3}``.
        prefix: Text before all names of the system, so that it lives beside others: ``"a."``.
        form: ``xml``, ``yaml`` or ``json``; None finds out.
        strict: Refuse a profile that needs repair.

    Raises:
        NotFound: The file cannot be read.
        InvalidDocument: It is no system profile, or its parameters make no sense; names file and
            line.
        Malformed: A value is for nothing that there is.
    """
    if isinstance(source, SystemProfile) and not (values or prefix):
        return source
    reader = cast("Session", _Reader(strict))
    given = _parameters(values or {}, prefix)
    if isinstance(source, SystemProfile):
        return parse_document(reader, source.source, source.data, source.form, given)
    from rtkit.profile.read import read_bytes

    name = os.fspath(source)
    if name.endswith(BUNDLE):
        from rtkit.packages.bundle import read_system as read_bytes
    return parse_document(reader, name, read_bytes(name), form, given)


class _Reader(NamedTuple):
    """The part of a session that reading a profile needs."""

    is_strict: bool

    def verbose(self, text: str) -> None:
        """See `Session.verbose`."""


def _parameters(values: Mapping[str, object], prefix: str) -> SystemParameters | None:
    if not (values or prefix):
        return None
    from rtkit.profile.parameters import GivenValue, SystemParameters

    texts = {k: str(v).lower() if isinstance(v, bool) else str(v) for k, v in values.items()}
    return SystemParameters(tuple(GivenValue(k, text, "") for k, text in texts.items()), prefix)


def with_hosts(document: SystemProfile, pairs: Iterable[str]) -> SystemProfile:
    """Return a profile with other hosts for some of its own, ``HOST=HOST``.

    Raises:
        UsageProblem: A pair is not of that form.
    """
    return replace(document, mapped=pairs_of("--map", "HOST=HOST", pairs))


def pairs_of(option: str, form: str, items: Iterable[str]) -> dict[str, str]:
    """Return the pairs that an option has.

    Raises:
        UsageProblem: One is not of the form.
    """
    pairs = {}
    for item in items:
        name, equals, value = item.partition("=")
        if not (name and equals and value):
            raise UsageProblem(f"{option} needs {form}: {item}")
        pairs[name] = value
    return pairs


def selected(
    document: SystemProfile, places: Mapping[str, str], left_out: Iterable[str], usual: str
) -> SystemProfile:
    """Return a profile with other places for components, and without some of its parts.

    See `rtkit.deployment.placement.selection`. It is as if it had been read so.

    Raises:
        NotFound: There is no such part.
        UsageProblem: A place is none.
    """
    names = list(left_out)
    if not (places or names):
        return document
    from rtkit.deployment.placement.selection import with_other_places, without_parts
    from rtkit.profile.write import write_profile

    profile = with_other_places(document.profile, places, usual)
    profile = without_parts(profile, names) if names else profile
    data = write_profile(profile)
    return replace(document, profile=profile, data=data, form="xml", resolved=None)


def made(profile: RtsProfile, source: str) -> SystemProfile:
    """Return a profile that was made here, not read."""
    from rtkit.profile.write import write_profile

    return SystemProfile(profile, write_profile(profile), source, "xml")
