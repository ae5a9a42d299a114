"""Profiles to build from, and what becomes of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rtkit.builder.component_files import Built, build
from rtkit.builder.prepare import Sources
from rtkit.builder.regions import stamped
from rtkit.builder.standard_types import KNOWN
from rtkit.idl.read import read_idl
from rtkit.profile.rtc_model import BasicInfo, RtcProfile

IDL = Path(__file__).parents[2] / "idl"
INFO = {
    "component_type": "STATIC",
    "activity_type": "PERIODIC",
    "component_kind": "DataFlowComponent",
    "category": "example",
    "vendor": "me",
    "version": "1.0",
    "execution_type": "PeriodicExecutionContext",
    "creation_date": "2020-01-01T00:00:00",
    "update_date": "2020-01-01T00:00:00",
}


class Builder:
    """Builds components of which only what matters is told."""

    def idl(self, *names: str) -> Any:
        text = "".join(f'#include "{name}"\n' for name in names)

        def find(name: str, _file: str) -> tuple[str, str] | None:
            file = IDL / name
            return (name, file.read_text()) if file.exists() else None

        return read_idl(text, "all", find, KNOWN)

    def build(self, name: str = "Foo", idl: tuple[str, ...] = (), **more: Any) -> Built:
        drawn = more.pop("drawn", None)
        own = {key: more.pop(key) for key in list(more) if key in BasicInfo.__dataclass_fields__}
        info = BasicInfo(name=name, **{**INFO, **own})
        profile = RtcProfile(id="RTC:x", version="0.3", basic_info=info, **more)
        return build(profile, Sources("stem", self.idl(*idl), drawn), idl)

    def code(self, *arguments: Any, **more: Any) -> str:
        """Return the lines of the class, without those that are always there."""
        built = self.build(*arguments, **more)
        text = built.files[f"{built.subject.module}.py"].text
        body = text.partition("# </user code imports>\n")[2].partition(
            "\n    # Callbacks that the profile does not ask for"
        )
        return body[0].strip("\n")

    def file(self, built: Built, name: str) -> str:
        file = built.files[name]
        return stamped(file.text, has_regions=file.has_regions)


@pytest.fixture
def builder() -> Builder:
    return Builder()
