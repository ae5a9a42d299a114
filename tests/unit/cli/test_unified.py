"""``rtkit VERB …``."""

from __future__ import annotations

import shutil
import subprocess
import sys

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit import __version__
from rtkit.cli.completion.functions import SHELLS, script
from rtkit.cli.shared.commands import COMMANDS, SUMMARIES, WORDS
from rtkit.cli.unified import run


def test_a_verb_is_its_command(world: FakeManager, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["ls", "/localhost/Std0.rtc"], fake_tree(world)) == 0
    assert run(["rtls", "/localhost/Std0.rtc"], fake_tree(world)) == 0
    assert capsys.readouterr() == ("Std0.rtc\n" * 2, "")


def test_messages_name_what_was_typed(
    world: FakeManager, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["ls", "/no"], fake_tree(world)) == 1
    assert run(["ls", "--zzz"], fake_tree(world)) == 2
    assert capsys.readouterr().err == (
        "rtkit ls: /no: no such host: no (add it: rthost add no USER@ADDRESS)\n"
        "Usage: rtkit ls [OPTIONS] [PATH]\n"
        "rtkit ls: No such option '--zzz'.\n"
    )


@pytest.mark.parametrize("argv", [[], ["-h"], ["--help"]])
def test_help_lists_every_verb(argv: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(argv) == 0
    out = capsys.readouterr().out
    assert out.startswith("Usage: rtkit VERB [OPTIONS] [ARGUMENTS]...\n")
    for verb, summary in (SUMMARIES | WORDS).items():
        assert any(line.split() == [verb, *summary.split()] for line in out.splitlines())
    assert all(len(line) <= 80 for line in out.splitlines())


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"rtkit {__version__}\n"


@pytest.mark.parametrize(
    ("verb", "said"),
    [
        ("lst", "no such verb: lst (did you mean ls"),
        ("rtlss", "no such verb: rtlss (did you mean rtls"),
        ("xyzzy", "no such verb: xyzzy (rtkit --help lists them)\n"),
        ("--verison", "no such option: --verison (did you mean --version?)\n"),
        ("-x", "no such option: -x (--help, --version)\n"),
        ("\x1b[2J", "no such verb: \\x1b[2J (rtkit --help lists them)\n"),
    ],
)
def test_an_unknown_verb(verb: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([verb]) == 2
    assert f"rtkit: {said}" in capsys.readouterr().err


def test_the_table_of_summaries_is_that_of_the_commands() -> None:
    assert list(SUMMARIES) == list(COMMANDS)


def test_a_shell_s_functions_are_printed(capsys: pytest.CaptureFixture[str]) -> None:
    for shell in SHELLS:
        assert run(["shell-init", shell]) == 0
        assert capsys.readouterr() == (f"{script(shell)}\n", "")
    assert run(["shell-init", "-h"]) == 0
    usage = "Usage: rtkit shell-init bash|zsh|fish\n"
    assert capsys.readouterr().out.startswith(usage)
    assert run(["shell-init"]) == 1
    assert capsys.readouterr() == ("", usage)
    assert run(["shell-init", "cmd"]) == 2
    told = "rtkit shell-init: no such shell: cmd (one of bash, zsh, fish)\n"
    assert capsys.readouterr() == ("", usage + told)


@pytest.mark.parametrize("shell", [name for name in SHELLS if shutil.which(name)])
def test_a_shell_takes_its_functions(shell: str) -> None:
    done = subprocess.run(
        [shell, "-c", f"{script(shell)}\ntype rtcwd"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "function" in done.stdout


@pytest.mark.parametrize(
    ("argv", "absent"),
    [
        ([], ("click", "difflib", "rtkit.cli.shared.app")),
        (["--version"], ("click", "difflib")),
        (["ls", "-h"], ("rtkit.cli.tree.rtcat", "rtkit.cli.managers.rtmgr", "zenoh")),
    ],
)
def test_only_what_is_asked_for_is_imported(argv: list[str], absent: tuple[str, ...]) -> None:
    script = (
        "import os, sys\n"
        f"sys.argv = ['rtkit', *{argv}]\n"
        "from rtkit.cli import main\n"
        "def end(status):\n"
        f"    print(status, [name for name in {absent} if name in sys.modules], file=sys.stderr)\n"
        "    leave(status)\n"
        "leave, os._exit = os._exit, end\n"
        "end(main())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "0 []\n")


def test_a_reader_that_leaves_is_no_error() -> None:
    script = (
        "import os, sys\n"
        "sys.argv = ['rtkit']\n"
        "sys.stdin.readline()\n"
        "from rtkit.cli import main\n"
        "sys.exit(main())\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        process.stdin.write(b"\n")
        process.stdin.close()
        assert process.stderr.read() == b""
        assert process.wait() == 141
