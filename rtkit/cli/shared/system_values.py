"""Reads the values and the prefix that the command line gives for a system profile."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App
from rtkit.cli.shared.options import option, setting, several, together
from rtkit.errors import InvalidDocument, UsageProblem

if TYPE_CHECKING:
    from rtkit.profile.parameters import GivenValue, SystemParameters
    from rtkit.profile.tree_read import Node

PARAMETERS = together(
    None,
    {
        "sets": several(
            "--set NAME=VALUE",
            "A variable of the profile, or a parameter, e.g. Camera0.noise=3; repeatable.",
            **setting("sets"),
        ),
        "values": several(
            "--values FILE",
            "Such values from a YAML file; those of --set come after them; repeatable.",
            **setting("values"),
        ),
        "prefix": option(
            "--prefix TEXT",
            "Text before all names of the system, e.g. a. for a.Camera0.",
            **setting("prefix"),
        ),
    },
)
"""The options of every command that reads a system profile; the run knows what they say."""


def parameters(app: App) -> SystemParameters | None:
    """Return what the command line gives, None for nothing: values of files, then those typed.

    Raises:
        NotFound: A file of values cannot be read.
        InvalidDocument: It is no YAML, or no table of values.
        UsageProblem: A word is not ``NAME=VALUE``.
    """
    if not (app.sets or app.values or app.prefix):
        return None
    from rtkit.profile.parameters import SystemParameters

    return SystemParameters(tuple(_given_values(app)), app.prefix)


def _given_values(app: App) -> Iterator[GivenValue]:
    from rtkit.profile.parameters import GivenValue

    for file in app.values:
        yield from _of_file(file)
    for text in app.sets:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals) or name.strip().endswith("."):
            raise UsageProblem(f"--set needs NAME=VALUE: {text}")
        yield GivenValue(name.strip(), value, f"--set {text}")


def _of_file(file: str) -> Iterator[GivenValue]:
    from rtkit.profile.read import read_bytes
    from rtkit.profile.tree_read import ScalarNode, decoded
    from rtkit.profile.yaml_text import read_yaml

    root = read_yaml(decoded(read_bytes(file), file), file)
    if not (isinstance(root, ScalarNode) and root.is_null):
        yield from _flat(root, file, "")


def _flat(node: Node, file: str, key: str) -> Iterator[GivenValue]:
    """Yield the values of a table; those of a table within it have its key before theirs."""
    from rtkit.profile.parameters import GivenValue
    from rtkit.profile.tree_read import ListNode, ScalarNode, TableNode

    origin = f"{file}:{node.line}"
    if isinstance(node, TableNode):
        for name, below in node.items:
            yield from _flat(below, file, f"{key}.{name.text}" if key else name.text)
    elif not key:
        raise InvalidDocument(f"{origin}: values are a table of names and values")
    elif isinstance(node, ListNode):
        items = [each.text for each in node.items if isinstance(each, ScalarNode)]
        if len(items) < len(node.items):
            raise InvalidDocument(f"{origin}: {key}: a list of values holds no tables or lists")
        yield GivenValue(key, ",".join(items), origin)
    elif node.is_null:
        raise InvalidDocument(f"{origin}: {key} has no value; '' is an empty one")
    else:
        yield GivenValue(key, node.text, origin)
