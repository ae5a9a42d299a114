"""Converts the source of a component that was written for OpenRTM-aist-Python."""

from __future__ import annotations

import ast
import os
from typing import NamedTuple

from rtkit.errors import Refused
from rtkit.openrtm.convert.class_writing import write_class
from rtkit.openrtm.convert.draft import API, HandWork, ModuleDraft
from rtkit.openrtm.convert.finishing import (
    reindented,
    with_even_gaps,
    with_imports,
    without_generated_comments,
    without_generated_docstrings,
)
from rtkit.openrtm.convert.foreign import mark_foreign
from rtkit.openrtm.convert.module_writing import write_module, write_outside
from rtkit.openrtm.convert.reading import read_components
from rtkit.openrtm.source import mended, read_source, with_spaces


class Conversion(NamedTuple):
    """A converted module.

    Attributes:
        text: Its source.
        marks: Places that need a hand, by line of the old source.
        components: Names of its component classes.
        ports: How many data ports were declared.
        parameters: How many parameters were declared.
    """

    text: str
    marks: tuple[HandWork, ...]
    components: tuple[str, ...]
    ports: int
    parameters: int


def convert(source: bytes, file: str) -> Conversion:
    """Return the native module of an old one.

    Args:
        source: What the file holds; encoding, tabs and Python 2 are mended first.
        file: Its name, for errors; modules and IDL stubs are looked for beside it.

    Raises:
        Refused: It has no component; or is Python 2 that cannot be mended.
        SyntaxError: It is Python of no version.
    """
    folder = os.path.dirname(file)
    text = _prepared(source, file)
    draft = ModuleDraft(text, folder)
    components = read_components(draft)
    if not components:
        raise Refused(f"{file} has no component: no class derives from {API}.DataFlowComponentBase")
    for component in components:
        write_class(draft, component)
    _remove_specs(draft)
    write_outside(draft, components)
    write_module(draft, components)
    mark_foreign(draft, components)
    converted = draft.source.result()
    converted = with_even_gaps(
        _finished(
            draft, converted, folder, [each.spec.get("description", "") for each in components]
        )
    )
    ast.parse(converted)
    return Conversion(
        converted,
        tuple(sorted(draft.marks)),
        tuple(each.node.name for each in components),
        sum(len(each.ports) for each in components),
        sum(len(each.parameters) + len(each.unbound) for each in components),
    )


def _prepared(source: bytes, file: str) -> str:
    """Return a source as Python 3 with blanks for tabs."""
    read = read_source(mended(source, file))
    text = with_spaces(read.text.replace("\r\n", "\n").replace("\r", "\n"))
    return text.lstrip("\ufeff").rstrip() + "\n"


def _finished(draft: ModuleDraft, text: str, folder: str, descriptions: list[str]) -> str:
    text = reindented(text)
    text = without_generated_comments(text)
    text = without_generated_docstrings(text, descriptions)
    return with_imports(draft, text, folder)


def _remove_specs(draft: ModuleDraft) -> None:
    """Leave out the lists of texts that only the registration uses."""
    source = draft.source
    for statement in source.tree.body:
        if not isinstance(statement, ast.Assign) or not isinstance(statement.targets[0], ast.Name):
            continue
        name = statement.targets[0].id
        uses = [
            node
            for node in ast.walk(source.tree)
            if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load)
        ]
        in_profiles = [
            node
            for node in uses
            if any(draft.call_of(each) == f"{API}.Properties" for each in source.ancestors(node))
        ]
        if uses and len(uses) == len(in_profiles):
            source.remove(statement)
