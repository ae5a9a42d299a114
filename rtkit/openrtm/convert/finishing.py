"""Finishes a converted source: imports, comments of code generators, indentation, empty lines."""

from __future__ import annotations

import ast
import inspect
import io
import os
import re
import tokenize
from collections.abc import Iterable, Iterator

from rtkit.openrtm.convert.draft import ModuleDraft
from rtkit.openrtm.convert.edits import SourceEdits, parsed
from rtkit.openrtm.convert.module_writing import is_foreign_import

_COMMENT = re.compile(r"^[ \t]*#")
_GENERATED = re.compile(
    r"^[ \t]*#[#\s]*(?:</?rtc-template.*|-\*- Python -\*-|-\*- coding:.*-\*-|\"\"\"|"
    r"(?:Bind variables and configuration variable|Set (?:In|Out)Port buffers?|"
    r"Set service (?:provider|consumers?) to Ports|Set CORBA Service Ports|"
    r"initialize of configuration-data\.?|Import RTM module|"
    r"Import Service (?:implementation class|stub modules)|This module'?s spesification|"
    r"Module specification|class constructor|Create a component|Initialize manager|"
    r"Activate manager.*|If you want to run the manager in .*|mgr\.runManager\(.*|"
    r"run the manager in blocking mode|runManager\(False\) is the default|"
    r"Set module initialization proced.*|This procedure will be invoked in .*|"
    r"[@\\](?:class|brief|param|return|if|else|endif)\b.*|form?aer rtc_.*|former rtc_.*|"
    r"This is same but different the former rtc_init_entry\(\)|"
    r"The (?:initialize|finalize|startup|shutdown|activated|deactivated|execution|aborting|error|"
    r"reset|state update) action\b.*|The action that is invoked (?:when execution|resetting).*|"
    r"The reset action that is invoked resetting|no corresponding operation exists.*|"
    r"def on[A-Z]\w*\(self.*|return RTC\.RTC_OK)\s*)$"
)
"""Comments that a generator of components writes around what it generates."""
_BARE = re.compile(r"^[ \t]*#[#\s]*$")
_MOST_WIDE = 99
_INTERPRETER = "#!/usr/bin/env python3"
_ESCAPED = {"\a": "\\a", "\b": "\\b", "\f": "\\f", "\r": "\\r", "\v": "\\v"}
"""What the tags of a generator have become in texts that are not raw: ``\\brief``."""


def without_generated_comments(text: str) -> str:
    """Return a source without the comments of code generators; others stay."""
    kept: list[str] = []
    block: list[str] = []
    strings = _lines_of_texts(text)
    for number, line in enumerate([*text.split("\n"), ""], 1):
        if number == 1 and line.startswith("#!"):
            kept.append(_INTERPRETER)
            continue
        if _COMMENT.match(line) and number not in strings:
            block.append(line)
            continue
        if block:
            kept += _cleaned(block)
            block = []
        kept.append(line)
    return "\n".join(kept[:-1])


def _cleaned(block: list[str]) -> list[str]:
    """Return what somebody wrote in a block of comments."""
    if not any(_GENERATED.match(line) for line in block):
        return [] if all(_BARE.match(line) for line in block) else block
    return [line for line in block if not _GENERATED.match(line) and not _BARE.match(line)]


def _lines_of_texts(text: str) -> set[int]:
    """Return the lines that lie inside of texts with several lines."""
    found: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.STRING and token.start[0] != token.end[0]:
            found.update(range(token.start[0] + 1, token.end[0] + 1))
    return found


def without_generated_docstrings(text: str, descriptions: Iterable[str] = ()) -> str:
    """Return a source whose docstrings have no lines of code generators.

    One of the module that only says what a component has as description is left out.
    """
    source = SourceEdits(text)
    for node in ast.walk(source.tree):
        if not isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            continue
        doc = _plain_docstring(node)
        first = node.body[0]
        if doc is None or not any(map(_is_generated_line, doc.splitlines())):
            continue
        kept = "\n".join(_without_tags(doc)).strip()
        if kept and not (isinstance(node, ast.Module) and kept in descriptions):
            indent = source.indent(first)
            lines = [line and f"{indent}{line}" for line in kept.splitlines()]
            ending = f"\n{indent}" if len(lines) > 1 else ""
            quoted = "\n".join(lines).strip().replace("\\", "\\\\")
            source.replace(first, f'"""{quoted}{ending}"""')
        else:
            source.remove(first)
    return source.result()


def _plain_docstring(node: ast.Module | ast.ClassDef | ast.FunctionDef) -> str | None:
    doc = ast.get_docstring(node, clean=False)
    for meant, text in _ESCAPED.items():
        doc = doc.replace(meant, text) if doc else doc
    return inspect.cleandoc(doc) if doc else doc


def _is_generated_line(line: str) -> bool:
    return bool(_GENERATED.match(f"# {line.strip()}")) or _is_tag(line)


def _is_tag(line: str) -> bool:
    return re.match(r"\s*[@\\](file|brief|date|class|author|param|return)\b", line) is not None


def _without_tags(doc: str) -> Iterator[str]:
    for line in doc.splitlines():
        bare = line.strip()
        tag = re.match(r"[@\\](file|brief|date|class|param|return|author)\b\s*(.*)", bare)
        if tag is not None:
            text = tag[2]
            is_kept = tag[1] in ("brief", "author") and text and text != "ModuleDescription"
            if is_kept and text not in ("constructor",):
                yield text if tag[1] == "brief" else f"Author: {text}"
        elif not _GENERATED.match(f"# {bare}"):
            yield line


def with_imports(draft: ModuleDraft, text: str, folder: str) -> str:
    """Return a source that imports what it uses, and nothing else."""
    source = SourceEdits(without_path_statements(text))
    used = {node.id for node in ast.walk(source.tree) if isinstance(node, ast.Name)}
    used |= _exported(source.tree)
    last: ast.stmt | None = None
    for statement in ast.walk(source.tree):
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            _write_import(draft, source, statement, used, folder)
    for statement in source.tree.body:
        if isinstance(statement, (ast.Import, ast.ImportFrom)):
            last = statement
    lines = _needed_imports(draft, used)
    if last is not None:
        source.insert_below(last, "".join(f"{each}\n" for each in lines))
    else:
        source.insert_before(source.tree.body[0], [*lines, ""])
    return source.result()


def _exported(tree: ast.Module) -> set[str]:
    return {
        each.value
        for node in tree.body
        if isinstance(node, ast.Assign)
        and any(isinstance(t, ast.Name) and t.id == "__all__" for t in node.targets)
        for each in ast.walk(node.value)
        if isinstance(each, ast.Constant) and isinstance(each.value, str)
    }


def without_path_statements(text: str) -> str:
    """Return a source that leaves the path of modules as it is."""
    source = SourceEdits(text)
    for statement in source.tree.body:
        if _is_path_statement(statement):
            source.remove(statement)
    return source.result()


def _is_path_statement(statement: ast.stmt) -> bool:
    """Return whether a statement adds the working directory to the path, as old modules do."""
    return isinstance(statement, ast.Expr) and ast.unparse(statement) in (
        "sys.path.append('.')",
        "sys.path.insert(0, '.')",
    )


def _write_import(
    draft: ModuleDraft,
    source: SourceEdits,
    statement: ast.Import | ast.ImportFrom,
    used: set[str],
    folder: str,
) -> None:
    if is_foreign_import(draft, statement):
        source.remove(statement)
        return
    if isinstance(statement, ast.ImportFrom) and statement.names[0].name == "*":
        names = sorted(_offered(folder, statement.module or "") & used)
        if names:
            source.replace(statement, f"from {statement.module} import {', '.join(names)}")
        elif _offered(folder, statement.module or ""):
            source.remove(statement)
        return
    kept = [
        each
        for each in statement.names
        if (each.asname or each.name.partition(".")[0]) in used
        and not (isinstance(statement, ast.Import) and each.name.partition(".")[0] in draft.stubs)
    ]
    if isinstance(statement, ast.ImportFrom) and statement.module == "__future__":
        return
    if not kept:
        source.remove(statement)
    elif len(kept) < len(statement.names):
        names_text = ", ".join(f"{e.name} as {e.asname}" if e.asname else e.name for e in kept)
        head = f"from {statement.module} " if isinstance(statement, ast.ImportFrom) else ""
        source.replace(statement, f"{head}import {names_text}")


def _offered(folder: str, module: str) -> set[str]:
    """Return the names that a module beside the component binds; empty if it cannot be read."""
    from rtkit.errors import RtkitError
    from rtkit.openrtm.migrate.source import mended, read_source

    path = os.path.join(folder, *module.split(".")) + ".py"
    try:
        with open(path, "rb") as file:
            tree = parsed(read_source(mended(file.read(), path)).text)
    except (OSError, SyntaxError, RtkitError):
        return set()
    found: set[str] = set()
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, ast.Assign):
            found |= {
                each.id
                for each in ast.walk(node)
                if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
            }
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            found |= {each.asname or each.name.partition(".")[0] for each in node.names}
    return found


def _needed_imports(draft: ModuleDraft, used: set[str]) -> list[str]:
    lines = []
    if draft.uses_replace:
        is_plain = "replace" not in draft.names
        lines.append("from dataclasses import replace" if is_plain else "import dataclasses")
    lines.append("")
    names = sorted(
        (name if name == alias else f"{name} as {alias}")
        for name, alias in draft.imported.items()
        if alias in used
    )
    lines += ["import rtkit"] if "rtkit" in used else []
    line = f"from rtkit.component import {', '.join(names)}"
    if not names:
        return lines
    if len(line) <= _MOST_WIDE:
        return [*lines, line]
    return [*lines, "from rtkit.component import (", *(f"    {each}," for each in names), ")"]


def reindented(text: str) -> str:
    """Return a source with four blanks for each level."""
    lines = text.split("\n")
    shifts: dict[int, int] = {}
    stack = [0]
    fixed = _lines_of_texts(text)
    pending: list[int] = []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        row = token.start[0]
        if token.type == tokenize.INDENT:
            stack.append(len(token.string))
        elif token.type == tokenize.DEDENT:
            stack.pop()
        elif token.type == tokenize.COMMENT and not lines[row - 1][: token.start[1]].strip():
            pending.append(row)
        elif token.type not in (
            tokenize.NL,
            tokenize.NEWLINE,
            tokenize.COMMENT,
            tokenize.ENDMARKER,
        ):
            shift = 4 * (len(stack) - 1) - stack[-1]
            for each in pending:
                shifts[each] = _comment_shift(lines[each - 1], stack)
            pending = []
            for each in range(row, token.end[0] + 1):
                if each not in fixed:
                    shifts.setdefault(each, shift)
    return "\n".join(_shifted(line, shifts.get(row, 0)) for row, line in enumerate(lines, 1))


def _comment_shift(line: str, stack: list[int]) -> int:
    width = len(line) - len(line.lstrip())
    level = max((n for n, indent in enumerate(stack) if indent <= width), default=0)
    return 4 * level - width


def _shifted(line: str, shift: int) -> str:
    bare = line.lstrip(" ")
    width = len(line) - len(bare)
    return " " * max(0, width + shift) + bare if bare else ""


def with_even_gaps(text: str) -> str:
    """Return a source with the empty lines that are usual between its parts."""
    lines = [line.rstrip() for line in text.split("\n")]
    inside = _lines_of_texts(text)
    found: list[str] = []
    gap = 0
    for number, line in enumerate(lines, 1):
        if number in inside:
            found.append(lines[number - 1] if gap == 0 else line)
            continue
        if not line:
            gap += 1
            continue
        if found:
            found += [""] * _gap_before(line, found, gap, lines[number:])
        gap = 0
        found.append(line)
    return "\n".join(found).strip("\n") + "\n"


def _gap_before(line: str, found: list[str], gap: int, rest: Iterable[str]) -> int:
    """Return how many empty lines stand before a line."""
    before = found[-1]
    begins = re.match(r"(\s*)(def|class|@|if __name__)", line)
    if line.lstrip().startswith("#") and not line.startswith(" "):
        following = next((each for each in rest if each and not each.startswith("#")), "")
        if re.match(r"(def|class|@)", following) and not before.startswith("#"):
            return 2
    if before.lstrip().startswith(("@", "#")) and before.startswith(
        line[: len(line) - len(line.lstrip())]
    ):
        return 0 if before.lstrip().startswith("@") or begins else min(gap, 1)
    if begins and not begins[1]:
        return 2
    if (
        not line.startswith((" ", "#"))
        and before.startswith(" ")
        and not before.strip().startswith(")")
    ):
        return 2 if not re.match(r"[)\]}]|else|elif|except|finally", line) else 0
    if before.rstrip().endswith(":"):
        return 0
    if begins:
        return 1
    return min(gap, 1)
