"""Converts the source of a component that was written for OpenRTM-aist-Python."""

from __future__ import annotations

import ast
import os
from tokenize import TokenError
from typing import NamedTuple

from rtkit.errors import Malformed, Refused
from rtkit.openrtm.convert.class_writing import write_class
from rtkit.openrtm.convert.component_model import OldComponent
from rtkit.openrtm.convert.draft import API, HandWork, ModuleDraft
from rtkit.openrtm.convert.edits import parsed
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
from rtkit.openrtm.migrate.source import mended, read_source, with_spaces
from rtkit.openrtm.migrate.to_python3 import converted


class Conversion(NamedTuple):
    """A converted module.

    Attributes:
        text: Its source.
        marks: Places that need a hand, by line of the old source.
        components: Names of its component classes.
        ports: How many data ports were declared.
        parameters: How many parameters were declared.
        remarks: What a person should look at where the old source was Python 2, by line.
    """

    text: str
    marks: tuple[HandWork, ...]
    components: tuple[str, ...]
    ports: int
    parameters: int
    remarks: tuple[tuple[int, str], ...] = ()


def convert(source: bytes, file: str) -> Conversion:
    """Return the native module of an old one.

    Args:
        source: What the file holds; encoding, tabs and Python 2 are mended first.
        file: Its name, for errors; modules and IDL stubs are looked for beside it.

    Raises:
        Refused: It has no component; or it is Python 2, and what converts that is not installed.
        Malformed: It is Python of no version.
    """
    migrated = converted(source, file)
    remarks = tuple((each.line, each.text) for each in migrated.remarks) if migrated else ()
    text = _prepared(migrated.data if migrated else source, file)
    draft = ModuleDraft(text, os.path.dirname(file))
    components = read_components(draft)
    if not components:
        raise Refused(f"{file} has no component: no class derives from {API}.DataFlowComponentBase")
    for component in components:
        write_class(draft, component)
    _remove_specs(draft)
    write_outside(draft, components)
    write_module(draft, components)
    mark_foreign(draft, components)
    return Conversion(
        _finished(draft, file, components),
        tuple(sorted(draft.marks)),
        tuple(each.node.name for each in components),
        sum(len(each.ports) for each in components),
        sum(len(each.parameters) + len(each.unbound) for each in components),
        remarks,
    )


def _prepared(source: bytes, file: str) -> str:
    """Return a source with blanks for tabs, and with usual ends of lines."""
    read = read_source(mended(source, file))
    text = with_spaces(read.text.replace("\r\n", "\n").replace("\r", "\n"))
    return text.lstrip("\ufeff").rstrip() + "\n"


def _finished(draft: ModuleDraft, file: str, components: list[OldComponent]) -> str:
    descriptions = [each.spec.get("description", "") for each in components]
    try:
        text = reindented(draft.source.result())
        text = without_generated_comments(text)
        text = without_generated_docstrings(text, descriptions)
        text = with_even_gaps(with_imports(draft, text, os.path.dirname(file)))
        parsed(text)  # a mistake of ours shows here, not where the module is loaded
    except (SyntaxError, TokenError) as error:
        raise Malformed(f"{file} cannot be converted: its result is no Python: {error}") from error
    return text


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
