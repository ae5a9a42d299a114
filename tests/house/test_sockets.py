"""Each connection to a unix socket is made where it is checked that no stranger laid the socket."""

from __future__ import annotations

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2] / "rtkit"
CONNECTS = "link/unix.py"
LISTENS = {
    "manager/daemon.py",
    "manager/slaves/warm_up.py",
    "wires/line/endpoint.py",
}
MAKES_ENDPOINTS = "link/zenoh.py"
KNOWS_THE_UNCHECKED_FOLDER = {
    "api/observers.py",
    "cli/managers/doctor/folders.py",
    "cli/managers/words.py",
    "link/insecure.py",
    "link/places.py",
    "link/running.py",
    "manager/daemon.py",
    "web/opening.py",
    "wires/line/endpoint.py",
}
"""To make it for this user alone, or to tell what is wrong with it."""


def _words(path: Path) -> set[str]:
    """Return the names, attributes and texts that a file uses, not those of its docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    words = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            words.add(node.id)
        elif isinstance(node, ast.Attribute):
            words.add(f".{node.attr}")
        elif isinstance(node, ast.alias):
            words.add(node.name)
        elif (
            isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs
        ):
            words.add(repr(node.value))
    return words


FILES = {str(path.relative_to(ROOT)): _words(path) for path in ROOT.rglob("*.py")}


def _with(*wanted: str) -> set[str]:
    return {name for name, words in FILES.items() if words & set(wanted)}


def test_unix_sockets_are_connected_to_in_one_file() -> None:
    assert _with(".AF_UNIX", "AF_UNIX") == {CONNECTS} | LISTENS
    assert not {name for name in LISTENS if FILES[name] & {".connect", ".connect_ex"}}


def test_endpoints_of_unix_sockets_are_written_in_one_file() -> None:
    found = {name for name, words in FILES.items() if any("unixsock" in word for word in words)}
    assert found == {MAKES_ENDPOINTS}


def test_the_folder_of_sockets_is_taken_unchecked_only_to_make_or_diagnose_it() -> None:
    assert _with("runtime_path", ".runtime_path") == KNOWS_THE_UNCHECKED_FOLDER
    named = {name for name in FILES if "'XDG_RUNTIME_DIR'" in FILES[name]}
    assert named <= {"link/places.py", "cli/managers/doctor/installation.py"}
