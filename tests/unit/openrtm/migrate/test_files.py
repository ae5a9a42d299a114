"""Files migrated together with what they import."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import jsonrecords
import pytest

from rtkit.cli.shared.commands import load
from rtkit.errors import Malformed, NotFound
from rtkit.openrtm.migrate import files as migration
from rtkit.openrtm.migrate.files import migrate, plan_migration

FILES = {
    "Main.py": "import os, near as n\nfrom pkg.inner import thing\n# import comment\nprint n\n",
    "near.py": "from far import *\n'''\nimport text\n'''\nx = raw_input()\n",
    "far.py": "import Main\nprint 'far'\n",
    "pkg/__init__.py": "from . import other\n",
    "pkg/inner.py": "from .other import x\nprint x\n",
    "pkg/other.py": "x = 1\n",
    "comment.py": "print 'nobody imports it'\n",
    "text.py": "print 'nobody imports it'\n",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "pkg").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(folder: Path) -> dict[str, str]:
    files = sorted(each for each in folder.rglob("*") if each.is_file())
    return {str(each.relative_to(folder)): each.read_text(encoding="utf-8") for each in files}


def test_a_file_is_migrated_with_what_it_imports(folder: Path) -> None:
    plan = plan_migration(["Main.py"])
    assert {each.path: each.beside for each in plan.files} == {
        "Main.py": False, "near.py": True, "far.py": True, "pkg/inner.py": True,
    }  # fmt: skip
    assert set(plan.looked_at) == FILES.keys() - {"comment.py", "text.py"}
    assert contents(folder) == FILES, "a plan writes nothing"
    kept = migrate(plan)
    assert kept["near.py"] == str(folder / "near.py.orig")
    after = contents(folder)
    assert after["near.py.orig"] == FILES["near.py"]
    assert after["near.py"].endswith("x = input()\n")
    assert after["pkg/other.py"] == FILES["pkg/other.py"]
    assert plan_migration(["Main.py"]).files == ()


def test_modules_of_a_package_import_siblings_with_a_dot(folder: Path) -> None:
    (folder / "pkg" / "inner.py").write_text("import other\nimport far\n", encoding="utf-8")
    (found,) = (each for each in plan_migration(["Main.py"]).files if "inner" in each.path)
    assert found.source.after == "from . import other\nimport far\n"
    assert plan_migration(["pkg/inner.py"]).files == (), "its folder may be one of components"


def test_originals_that_are_kept_already_stay(folder: Path) -> None:
    (folder / "comment.py.orig").write_text("mine", encoding="utf-8")
    assert migrate(plan_migration(["comment.py"])) == {
        "comment.py": str(folder / "comment.py.orig2")
    }
    assert (folder / "comment.py.orig").read_text(encoding="utf-8") == "mine"


def test_one_that_cannot_be_converted_leaves_all_as_they_are(folder: Path) -> None:
    (folder / "far.py").write_text("def f(:\n", encoding="utf-8")
    before = contents(folder)
    with pytest.raises(Malformed, match=r"far\.py:1"):
        plan_migration(["Main.py"])
    assert contents(folder) == before


def test_one_that_cannot_be_written_has_the_others_put_back(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write: Callable[[bytes, str], None] = migration.write_output

    def fail_at_inner(data: bytes, output: str) -> None:
        if output.endswith("inner.py"):
            raise NotFound(f"cannot write {output}: No space left on device")
        write(data, output)

    monkeypatch.setattr(migration, "write_output", fail_at_inner)
    with pytest.raises(NotFound, match=r"nothing was migrated: pkg/inner\.py: .*No space left"):
        migrate(plan_migration(["Main.py"]))
    assert contents(folder) == FILES


def test_originals_are_kept_where_there_are_no_hard_links(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuse)
    migrate(plan_migration(["comment.py"]))
    assert (folder / "comment.py.orig").read_text(encoding="utf-8") == FILES["comment.py"]
    assert (folder / "comment.py").read_text(encoding="utf-8") == "print('nobody imports it')\n"


def test_a_link_stays_a_link(folder: Path) -> None:
    (folder / "link.py").symlink_to("comment.py")
    kept = migrate(plan_migration(["link.py"]))
    assert kept["link.py"] == str(folder / "comment.py.orig")
    assert os.readlink("link.py") == "comment.py"


def test_the_command_shows_changes_and_tells_what_became_of_each(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = load("rtopenrtm")
    assert run(["migrate", "--dry-run", "near.py"]) == 0
    told = capsys.readouterr()
    assert "-x = raw_input()\n+x = input()\n" in told.out
    assert "near.py (Python 2: raw_input, line 5): would be converted" in told.err
    assert contents(folder) == FILES
    assert run(["migrate", "--json", "near.py"]) == 0
    records = jsonrecords.checked(capsys.readouterr().out)
    assert {jsonrecords.kind_of(each) for each in records} == {"migrated-file"}
    assert [each["is_imported"] for each in records] == [False, True, True, True]
    assert records[0]["original"] == str(folder / "near.py.orig")
    assert run(["migrate", "near.py"]) == 0
    assert "nothing to do: 6 files are Python 3" in capsys.readouterr().err


def test_the_command_tells_what_nobody_can_mend_for_certain(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "import threading, time\nx.isAlive()\n"
    (folder / "alive.py").write_text(text, encoding="utf-8")
    run = load("rtopenrtm")
    assert run(["migrate", "alive.py"]) == 0
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.splitlines()[0].endswith("alive.py:2: look at it: threads have is_alive in"
                                             " place of isAlive since Python 3.9")  # fmt: skip
    assert "nothing to do: 1 file is Python 3" in told.err
    assert not (folder / "alive.py.orig").exists()
    assert run(["migrate", "--json", "alive.py"]) == 0
    (record,) = jsonrecords.checked(capsys.readouterr().out)
    assert (record["changes"], record["original"], record["why"]) == ([], None, "isAlive")
    (folder / "alive.py").write_text(f"{text}time.clock()\n", encoding="utf-8")
    assert run(["migrate", "alive.py"]) == 0
    assert "alive.py (an older Python: isAlive, line 2): converted" in capsys.readouterr().err


def test_the_command_names_what_it_cannot_read(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = load("rtopenrtm")
    assert run(["migrate", "Nothing.py"]) == 1
    assert "cannot read Nothing.py: No such file or directory" in capsys.readouterr().err
    assert run(["migrate"]) == 1
