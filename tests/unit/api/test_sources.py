"""Sources that are watched: what counts as saved, and what is wrong with it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rtkit.api.sources import SourceFiles, check_imports, syntax_errors
from rtkit.errors import Refused


@pytest.fixture
def module(tmp_path: Path) -> Path:
    file = tmp_path / "Scale.py"
    file.write_text("a = 1\n")
    return file


@pytest.fixture
def sources(module: Path) -> SourceFiles:
    sources = SourceFiles()
    sources.follow([str(module)])
    assert sources.saved() == []
    return sources


def truncated_and_written(file: Path) -> None:
    file.write_text("")
    file.write_text("a = 22\n")


def moved_into_place(file: Path) -> None:
    draft = file.with_suffix(".tmp")
    draft.write_text("a = 2\n")
    draft.replace(file)


@pytest.mark.parametrize("save", [truncated_and_written, moved_into_place])
def test_a_saved_file_is_told_once_when_two_looks_find_the_same(
    sources: SourceFiles, module: Path, save: object
) -> None:
    assert callable(save)
    save(module)
    assert [sources.saved(), sources.saved(), sources.saved()] == [[], [str(module)], []]


def test_between_truncating_and_writing_nothing_is_told(sources: SourceFiles, module: Path) -> None:
    module.write_text("")
    assert sources.saved() == []
    module.write_text("a = 22\n")
    assert [sources.saved(), sources.saved()] == [[], [str(module)]]


def test_a_file_that_is_missing_for_a_moment_is_waited_for(
    sources: SourceFiles, module: Path
) -> None:
    backup = module.with_suffix(".bak")
    module.rename(backup)
    assert [sources.saved() for _ in range(4)] == [[]] * 4
    backup.rename(module)
    assert [sources.saved(), sources.saved()] == [[], []]
    module.unlink()
    told = [sources.saved() for _ in range(10)]
    assert [each for each in told if each] == [[str(module)]]


def test_sources_beside_it_are_watched_too_and_hidden_ones_are_not(
    sources: SourceFiles, module: Path
) -> None:
    (module.parent / "idl").mkdir()
    for name in ("helper.py", "Robot.idl", "idl/Hand.idl", "part.xml", ".#Scale.py", "notes.txt"):
        (module.parent / name).write_text("x")
    assert sources.saved() == []
    assert sources.saved() == [
        str(module.parent / name) for name in ("Robot.idl", "helper.py", "idl/Hand.idl", "part.xml")
    ]


def test_what_was_saved_before_it_is_followed_again_is_told(
    sources: SourceFiles, module: Path
) -> None:
    moved_into_place(module)
    sources.follow([str(module)])
    assert sources.saved() == [str(module)]


def test_a_syntax_error_has_file_and_line(module: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(module.parent)
    module.write_text("a = 1\nb = (\n")
    (text,) = syntax_errors([str(module)])
    assert text == "Scale.py:2: SyntaxError: '(' was never closed"
    module.write_bytes(b"a = '\xff'\n")
    (text,) = syntax_errors([str(module)])
    assert text.startswith("Scale.py:1: SyntaxError: ")
    module.write_text("a = 'x' is 'x'\n")  # a warning at most
    assert list(syntax_errors([str(module)])) == []


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("import nowhere\ndef ScaleInit(manager): pass\n", "Scale.py:1"),
        ("a = 1\n", "no init function ScaleInit"),
        ("import os\nos._exit(3)\n", "Scale.py: exit status 3"),
        ("def ScaleInit(manager): pass\n", ""),
    ],
)
def test_a_module_is_imported_in_another_process_first(
    module: Path, monkeypatch: pytest.MonkeyPatch, text: str, why: str
) -> None:
    monkeypatch.chdir(module.parent)
    module.write_text(text)
    if not why:
        check_imports([(os.fspath(module), "")])
        return
    with pytest.raises(Refused, match=why):
        check_imports([(os.fspath(module), "")])
