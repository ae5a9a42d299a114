"""A system profile that is open in the editor: its history, what it shows, and its file.

The server holds the model; a page sends edits and gets the new picture. Profiles are immutable, so
each step of the history is a whole one, and undo is exact.
"""

from __future__ import annotations

import os
from datetime import datetime
from typing import NamedTuple

from rtkit.api.component_profiles import SEARCH_PATH
from rtkit.api.live_records import Record, SystemRecords
from rtkit.deployment.described import type_of
from rtkit.errors import Malformed, Refused, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.link.atomic import write_output
from rtkit.manager.limits.control_groups import capacity
from rtkit.profile import rts_model as rts
from rtkit.profile.examine import examine
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.forms import XML, form_of, form_of_name, has_parameters
from rtkit.profile.parameters.reading import SystemReading, read_system
from rtkit.profile.read import read_bytes
from rtkit.profile.write import write_profile
from rtkit.profile_tools.rewriting import rewritten
from rtkit.profile_tools.system_edits import identity
from rtkit.report.finding import ERROR, WARNING
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.check import findings
from rtkit.web.documents.component_types import TypeStock
from rtkit.web.documents.document_view import (
    DocumentView,
    bends_of,
    finding_records,
    places_of,
    records_of_view,
    viewed,
)
from rtkit.web.live.arrange import arranged

_MOST_STEPS = 1000


class EditStep(NamedTuple):
    """A state of a document, and the sentence that tells what led to it."""

    profile: rts.RtsProfile
    text: str


class Document:
    """One open document.

    Attributes:
        id: Its number.
        file: Its path; empty for one that was never saved.
        form: ``xml``, ``yaml`` or ``json``.
        revision: Grows with each change.
        view: What is shown of it now.
        catalogue: What is known of its component types.
        draft_trouble: Why it is not kept beyond the end of the server; empty where it is.
    """

    view: DocumentView
    catalogue: Catalogue

    def __init__(
        self, id: str, profile: rts.RtsProfile, types: TypeStock, file: str = "", data: bytes = b""
    ) -> None:
        """Begin with a profile; `data` is what its file holds."""
        self.id = id
        self.file = file
        self.form = form_of(data, file) if data else XML
        self.revision = 0
        self._types = types
        self._data = data
        self._saved: rts.RtsProfile | None = profile if data else None
        self._steps = [EditStep(profile, "")]
        self._at = 0
        self._known: set[str] | None = None
        self._layout: tuple[object, Record] = (None, {})
        self._notes = rewritten(data, file).findings if data else ()
        self._trouble = ""
        self._is_outdated = False
        self.draft_trouble = ""
        self._look()

    @property
    def data(self) -> bytes:
        """Return what its file held when it was read or written last."""
        return self._data

    @property
    def profile(self) -> rts.RtsProfile:
        """Return the profile as it stands, not resolved."""
        return self._steps[self._at].profile

    @property
    def is_changed(self) -> bool:
        """Return whether it is another one than that of its file."""
        return self.profile != self._saved

    def edit(self, profile: rts.RtsProfile, text: str) -> None:
        """Take an edit; what was undone before cannot be done again."""
        if profile == self.profile:
            return
        self._steps = [*self._steps[: self._at + 1], EditStep(profile, text)][-_MOST_STEPS:]
        self._at = len(self._steps) - 1
        self._changed()

    def recover(self, profile: rts.RtsProfile, *, is_outdated: bool) -> None:
        """Take what an earlier server kept; `is_outdated` where the file is another one by now."""
        self._is_outdated = is_outdated
        self.edit(profile, "Take back what was not saved")

    def move(self, steps: int) -> None:
        """Undo (-1) or do again (1).

        Raises:
            Refused: There is nothing to.
        """
        if not 0 <= self._at + steps < len(self._steps):
            raise Refused("there is nothing to undo" if steps < 0 else "there is nothing to redo")
        self._at += steps
        self._changed()

    def save(self, file: str, *, is_replaced: bool) -> None:
        """Write it into a file, in the form that the ending of its name tells.

        Raises:
            Refused: The file is there, or was changed since this document was read.
            NotFound: It cannot be written.
        """
        if os.path.exists(file) and not is_replaced:
            if file != self.file:
                raise Refused(f"{file} is there already")
            if self._is_outdated or read_bytes(file) != self._data:
                raise Refused(f"{file} was changed by somebody else since it was opened")
        form = form_of_name(file) or XML
        if self.is_changed:
            now = datetime.now().astimezone().replace(microsecond=0).isoformat()
            step = self._steps[self._at]
            self._steps[self._at] = step._replace(profile=replace(step.profile, update_date=now))
        data = write_profile(self.profile, form)
        write_output(data, file)
        self.file, self.form, self._data, self._saved = file, form, data, self.profile
        self._is_outdated = False
        self._notes = ()
        self._changed()

    def layout(self, records: SystemRecords, folded: list[str]) -> Record:
        """Return where everything is drawn; the same picture is not laid out twice."""
        shape = [
            (id, each["composite"], each["type"], *(port["name"] for port in each["ports"]))
            for id, each in records.components.items()
        ]
        wires = [(id, each["source"], each["target"]) for id, each in records.connectors.items()]
        key = (shape, wires, sorted(folded))
        if self._layout[0] != key:
            self._layout = (key, arranged(records, folded))
        return self._layout[1]

    def places(self) -> Record:
        """Return where components stand by their profile [pixel]."""
        return places_of(self.view)

    def heading(self) -> Record:
        """Return what a list of open documents tells of it."""
        return {
            "id": self.id,
            "file": self.file,
            "name": identity(self.profile)[1],
            "is_changed": self.is_changed,
            "revision": self.revision,
        }

    def record(self, folded: list[str]) -> Record:
        """Return everything about it; see ``Picture`` in ``web/src/rooms/document/types.ts``."""
        records = records_of_view(self.view, self.catalogue)
        profile = self.profile
        vendor, name, version = identity(profile)
        undone = self._steps[self._at + 1].text if self._at + 1 < len(self._steps) else None
        return {
            **self.heading(),
            "form": self.form,
            "undo": self._steps[self._at].text if self._at else None,
            "redo": undone,
            "profile": {
                "vendor": vendor, "name": name, "version": version,
                "abstract": profile.abstract or "", "comment": profile.comment or "",
                "created": profile.creation_date, "updated": profile.update_date,
                "log": list(profile.version_up_logs),
            },
            "variables": [
                {"name": each.name, "value": each.default, "description": each.description or ""}
                for each in profile.variables
            ],
            "includes": [
                {"file": each.file, "prefix": each.prefix or "",
                 "values": {value.name: value.value for value in each.values}}
                for each in profile.includes
            ],
            "groups": [
                {"id": each.group_id, "members": [m.instance_name for m in each.members]}
                for each in self.view.profile.groups
            ],
            "components": list(records.components.values()),
            "connectors": list(records.connectors.values()),
            "layout": {"revision": self.revision, **self.layout(records, folded)},
            "places": self.places(),
            "bends": bends_of(self.view.profile),
            "findings": self._findings(),
        }  # fmt: skip

    def _findings(self) -> list[Record]:
        """Return what ``rtprofile check`` tells of it as it stands, and what its file was like."""
        trouble = {"severity": ERROR, "rule": "", "text": self._trouble, "allowed": "", "on": ""}
        checked = finding_records(self.view, findings(self.view.profile, self.catalogue, capacity))
        notes = [
            {"severity": each.severity, "rule": each.rule, "allowed": "", "on": "",
             "text": f"line {each.line}: {each.text}"}
            for each in self._notes
        ]  # fmt: skip
        kept = {
            "severity": WARNING, "rule": "", "allowed": "", "on": "",
            "text": f"It is not kept beyond the end of the server: {self.draft_trouble}",
        }  # fmt: skip
        return [
            *([trouble] if self._trouble else []),
            *([kept] if self.draft_trouble else []),
            *checked,
            *notes,
        ]

    def _changed(self) -> None:
        self.revision += 1
        self._look()

    def _look(self) -> None:
        """Resolve the profile, and look for types that were not needed before."""
        reading = self._resolved()
        shown = reading.profile if reading is not None else self.profile
        types = {type_of(each.id).type_name for each in shown.components}
        if self._known is None or not types <= self._known:
            self.catalogue = self._types.catalogue(types, self.file)
            self._known = types
        self.view = viewed(shown, self.catalogue, reading)

    def _resolved(self) -> SystemReading | None:
        """Return what it is with its variables and includes; None where it has none of these."""
        self._trouble = ""
        data = write_profile(self.profile, XML) if has_parameters(self._data) else b""
        if not has_parameters(data):
            return None
        folders = os.environ.get(SEARCH_PATH, "").split(os.pathsep)
        try:
            return read_system(data, self.file, form=XML, folders=folders)
        except InvalidProfile as error:
            self._trouble = "; ".join(f"{error.source}: {each.text}" for each in error.problems)
        except RtkitError as error:
            self._trouble = str(error)
        return None


def opened(id: str, file: str, types: TypeStock) -> Document:
    """Open the system profile in a file.

    Raises:
        NotFound: The file cannot be read.
        Malformed: It is no sound system profile; says where and why.
    """
    data = read_bytes(file)
    found = examine(data, file, kind="rts")
    if not isinstance(found.profile, rts.RtsProfile):
        texts = [f"line {each.line}: {each.text}" for each in found.errors[:5]]
        raise Malformed(f"{file} is no sound system profile: {'; '.join(texts)}")
    return Document(id, found.profile, types, file, data)
