"""Text that is no value: got and set as it is, quoted in lists of values."""

from __future__ import annotations

from rtkit.property.annotations import Text
from rtkit.property.objects import Exported
from rtkit.property.reading import read
from rtkit.property.service import Service


class Page:
    """Page with a text that is kept and one that is computed."""

    kept: Text = Text(":a :b ;")

    def get_made(self) -> Text:
        return Text(f"# {self.kept}")


def test_text_travels_as_it_is_and_is_quoted_among_values() -> None:
    service = Service()
    page = Page()
    Exported(service, page)
    assert service.get("kept.meta.type") == "text"
    service.set("kept", "(1 (2")
    assert page.kept == "(1 (2"
    assert service.get("made") == "# (1 (2"
    listed = dict(read(str(service.get("properties?values=1"))))  # type: ignore[arg-type]
    assert {str(name): listed[name] for name in listed} == {"made": "# (1 (2", "kept": "(1 (2"}
