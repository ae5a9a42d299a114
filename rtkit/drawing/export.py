"""Writes a scene in one of the forms of drawings; the one exporter of all that draws systems."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping

from rtkit.drawing.scene import Scene


def _svg(scene: Scene, title: str) -> str:
    from rtkit.drawing.svg import picture

    return picture(scene, title)


def _dot(scene: Scene, title: str) -> str:
    from rtkit.drawing.dot import dot_lines

    return "\n".join(dot_lines(scene, title)) + "\n"


def _mermaid(scene: Scene, title: str) -> str:
    from rtkit.drawing.mermaid import mermaid_lines

    return "\n".join(mermaid_lines(scene, title)) + "\n"


def _text(scene: Scene, title: str) -> str:
    from rtkit.drawing.outline import outline

    return "\n".join(outline(scene, title)) + "\n"


FORMS: Mapping[str, Callable[[Scene, str], str]] = {
    "svg": _svg,
    "dot": _dot,
    "mermaid": _mermaid,
    "text": _text,
}
_ENDINGS = {
    ".dot": "dot", ".gv": "dot", ".mmd": "mermaid", ".mermaid": "mermaid", ".txt": "text",
}  # fmt: skip


def form_of(file: str) -> str:
    """Return the form that the name of a file stands for, ``svg`` for all that it does not know."""
    return _ENDINGS.get(os.path.splitext(file)[1].lower(), "svg")


def exported(scene: Scene, form: str, title: str = "") -> str:
    """Return a scene in a form, one of `FORMS`, with a title."""
    return FORMS[form](scene, title)
