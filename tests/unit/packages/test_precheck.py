"""Which components rtkit makes by itself, so that no host is asked for packages of them."""

from __future__ import annotations

import pytest
import rts_text

from rtkit.packages.precheck import is_built_in
from rtkit.profile.read import read_rts


@pytest.mark.parametrize(
    ("type_id", "is_so"),
    [
        ("RTC:rtkit:example:ConsoleIn:1.0", True),
        ("RTC:rtkit:example:ConsoleOut:1.0", True),
        ("RTC:another:example:ConsoleOut:1.0", False),
        ("RTC:rtkit:example:ConsoleOut:9.0", False),
        ("RTC:me:test:Source:1.0", False),
    ],
)
def test_services_and_examples_are_built_in(type_id: str, is_so: bool) -> None:
    kind = type_id.split(":")[3]
    told = {"create": f"{kind}?manager_name=a"}
    text = rts_text.system("One", rts_text.component("A", told, type_id=type_id))
    (component,) = read_rts(text).profile.components
    assert is_built_in(component) is is_so
