"""Writes the types of `rtkit.aio` from those of `rtkit.Tree`: python tools/make_aio_stub.py."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path
from types import ModuleType

from rtkit import aio
from rtkit.api import data_tree, plan, properties, tree
from rtkit.tree import api as by_path
from rtkit.tree import client

STUB = Path(aio.__file__).with_suffix(".pyi")
_RENAMED = {"SystemPlan": "AsyncPlan", "Stream": "AsyncStream"}
_HEAD = '''"""Types of `rtkit.aio`, made of those of `rtkit.Tree` by tools/make_aio_stub.py."""

from collections.abc import Callable, Generator
from typing import Generic, Self, TypeVar

{imports}

T = TypeVar("T")

class AsyncStream(Generic[T]):
    def __aiter__(self) -> AsyncStream[T]: ...
    async def __anext__(self) -> T: ...
    async def __aenter__(self) -> AsyncStream[T]: ...
    async def __aexit__(self, *raised: object) -> None: ...
    async def aclose(self) -> None: ...

class AsyncPlan:
    profile: SystemProfile
    cost: float
    steps: list[str]
    def as_dict(self) -> Mapping[str, Any]: ...
    def dot(self) -> str: ...
    def __len__(self) -> int: ...
    def __bool__(self) -> bool: ...
'''
_TREE = """
class AsyncTree:
    host: str
    manager: str
    notify: Callable[[str], object]
    timeout_s: float
    @property
    def properties(self) -> AsyncProperties: ...
    async def __aenter__(self) -> Self: ...
    async def __aexit__(self, *raised: object) -> None: ...
"""
_TAIL = """
class Connecting:
    def __await__(self) -> Generator[Any, None, AsyncTree]: ...
    async def __aenter__(self) -> AsyncTree: ...
    async def __aexit__(self, *raised: object) -> None: ...

async def in_thread(call: Callable[[], T], *, is_orderly: bool = ...) -> T: ...
def waits(cls: type) -> list[str]: ...
def connect(
    manager: str = ...,
    timeout_s: float = ...,
    *,
    start: bool = ...,
    notify: Callable[[str], object] | None = ...,
) -> Connecting: ...
"""


def text() -> str:
    """Return the stub."""
    imports = {"SystemProfile": "rtkit.api.system_profiles", "Mapping": "collections.abc"}
    applied = _methods(plan, ["apply"], imports)
    changes = _methods(properties, aio.waits(properties.Properties), imports)
    names = aio.waits(tree.Tree)
    homes = (tree, tree.Tree), (data_tree, data_tree.DataTree), (client, client.Tree)
    parts = []
    for module, cls in (*homes, (by_path, by_path.ByPath)):
        parts += _methods(module, [each for each in names if each in vars(cls)], imports)
        names = [each for each in names if each not in vars(cls)]
    lines = sorted(f"from {module} import {name}" for name, module in imports.items())
    whole = [_HEAD.format(imports="\n".join(lines)), *applied, "\nclass AsyncProperties:\n"]
    return _formatted("".join([*whole, *changes, _TREE, *parts, _TAIL]))


def _formatted(text: str) -> str:
    for how in (["check", "--fix", "--select=I,F401,F811"], ["format"]):
        line = [sys.executable, "-m", "ruff", *how, "--quiet", "--stdin-filename", str(STUB), "-"]
        done = subprocess.run(line, input=text, capture_output=True, text=True, check=True)
        text = done.stdout
    return text


def _methods(module: ModuleType, names: list[str], imports: dict[str, str]) -> list[str]:
    """Return the methods of a module's classes as those that are awaited; note what they need."""
    parsed = ast.parse(inspect.getsource(module))
    homes = _homes(parsed, module.__name__)
    found = {
        each.name: each
        for node in parsed.body
        if isinstance(node, ast.ClassDef)
        for each in node.body
        if isinstance(each, ast.FunctionDef) and each.name in names
    }
    return [_method(found[name], homes, imports) for name in sorted(names)]


def _homes(parsed: ast.Module, own: str) -> dict[str, str]:
    """Return where names of a module come from."""
    homes = {}
    for node in ast.walk(parsed):
        if isinstance(node, ast.ImportFrom) and node.module != "__future__":
            homes.update({each.name: str(node.module) for each in node.names})
    for node in parsed.body:
        if isinstance(node, ast.Assign):
            homes.update({t.id: own for t in node.targets if isinstance(t, ast.Name)})
        elif isinstance(node, ast.ClassDef):
            homes[node.name] = own
    return homes


def _method(function: ast.FunctionDef, homes: dict[str, str], imports: dict[str, str]) -> str:
    arguments = function.args
    for each in (*arguments.args, *arguments.kwonlyargs):
        each.annotation = None if each.arg == "self" else each.annotation
    arguments.defaults = [ast.Constant(...) for _ in arguments.defaults]
    arguments.kw_defaults = [each and ast.Constant(...) for each in arguments.kw_defaults]
    returned = ast.unparse(function.returns) if function.returns else "Any"
    for node in ast.walk(ast.Module([function], [])):
        name = node.id if isinstance(node, ast.Name) else ""
        if name in _RENAMED:
            continue
        if name in homes and _is_in_signature(function, name):
            imports[name] = homes[name]
    for old, new in _RENAMED.items():
        returned = returned.replace(old, new)
    is_stream = returned.startswith("AsyncStream[")
    head = "def" if is_stream else "async def"
    return f"    {head} {function.name}({ast.unparse(arguments)}) -> {returned}: ...\n"


def _is_in_signature(function: ast.FunctionDef, name: str) -> bool:
    parts = [function.args, *([function.returns] if function.returns else [])]
    return any(
        isinstance(node, ast.Name) and node.id == name for part in parts for node in ast.walk(part)
    )


if __name__ == "__main__":
    STUB.write_text(text(), encoding="utf-8")
