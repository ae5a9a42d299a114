"""The tree of errors, as it is drawn and as it is."""

from __future__ import annotations

import re

from rtkit import errors
from rtkit.errors import BUG_EXIT, RtkitError

_ROW = re.compile(r"^(?:[├└]─ )?(\w+)(?: \((\w+)\))? +([\w-]+) +(\d+) +(\d+)$", re.MULTILINE)


def test_the_drawn_tree_is_that_of_the_classes() -> None:
    drawn = _ROW.findall(errors.__doc__ or "")
    classes = [RtkitError, *RtkitError.__subclasses__()]
    classes = [each for each in classes if each.__module__ == errors.__name__]
    assert drawn == [
        (
            each.__name__,
            "".join(base.__name__ for base in each.__bases__[1:]),
            each.kind,
            str(each.exit_code),
            str(each.detail),
        )
        for each in classes
    ]
    assert f"bug             1      {BUG_EXIT}" in (errors.__doc__ or "")
