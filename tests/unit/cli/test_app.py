"""Errors, exit statuses, streams and interrupts: what all commands share."""

from __future__ import annotations

import io
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import click
import pytest

from rtkit import __version__
from rtkit.cli.shared import console_process, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import Main, command
from rtkit.cli.shared.commands import COMMANDS, load
from rtkit.errors import (
    Impossible,
    InvalidDocument,
    Malformed,
    NotFound,
    Partial,
    Refused,
    RtkitError,
    Unreachable,
    UsageProblem,
)

Run = Callable[[str], Any]
DETAILS = [
    (UsageProblem("m"), 2, 2),
    (Malformed("m"), 1, 2),
    (Refused("m"), 1, 1),
    (InvalidDocument("m"), 1, 3),
    (NotFound("m"), 1, 4),
    (Unreachable("m"), 1, 5),
    (Partial("m", [("x", Refused("why"))]), 1, 6),
    (ZeroDivisionError("m"), 1, 70),
]


def failing(error: BaseException) -> Main:
    @command("rtfail")
    def main(app: App) -> None:
        raise error

    return main


@pytest.fixture
def interrupts() -> Iterator[None]:
    before = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(("error", "status", "detail"), DETAILS)
def test_each_error_has_its_status(
    error: Exception, status: int, detail: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    main = failing(error)
    assert main([]) == status
    assert main(["--exit-detail"]) == detail
    monkeypatch.setenv("RTKIT_EXIT_DETAIL", "1")
    assert main([]) == detail
    monkeypatch.setenv("RTKIT_EXIT_DETAIL", "0")
    assert main([]) == status


def test_a_message_is_one_line_behind_the_name(capsys: pytest.CaptureFixture[str]) -> None:
    failing(Refused("no\nway \x1b[2J\x9b1m\u202eback"))([])
    assert capsys.readouterr().err == "rtfail: no\\nway \\x1b[2J\\x9b1m\\u202eback\n"


def test_the_name_is_what_was_typed(capsys: pytest.CaptureFixture[str]) -> None:
    failing(Refused("no"))([], name="rtkit fail")
    assert capsys.readouterr().err == "rtkit fail: no\n"


def test_a_bug_is_told_as_one(capsys: pytest.CaptureFixture[str]) -> None:
    main = failing(KeyError("x"))
    main([])
    told = "rtfail: KeyError: 'x'; this is a bug in rtkit; -v shows where\n"
    assert capsys.readouterr().err == told
    main(["-v"])
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "Traceback (most recent call last):"
    assert lines[-2:] == ["KeyError: 'x'", "rtfail: KeyError: 'x'; this is a bug in rtkit"]


def test_that_no_plan_exists_is_an_answer_without_traceback(
    capsys: pytest.CaptureFixture[str],
) -> None:
    failing(Impossible("no place for A"))(["-v"])
    assert capsys.readouterr().err == "rtfail: no place for A\n"


def test_failures_of_a_part_are_told_one_by_one(capsys: pytest.CaptureFixture[str]) -> None:
    failing(Partial("2 of 3 failed", [("a", Refused("no: a")), ("b", NotFound("gone: b"))]))([])
    told = "rtfail: no: a\nrtfail: gone: b\nrtfail: 2 of 3 failed\n"
    assert capsys.readouterr().err == told


def test_a_file_that_cannot_be_read_is_no_bug(capsys: pytest.CaptureFixture[str]) -> None:
    failing(PermissionError(13, "Permission denied", "/etc/x"))([])
    assert capsys.readouterr().err == "rtfail: Permission denied: /etc/x\n"


def test_an_interrupt_is_one_line_and_130(capsys: pytest.CaptureFixture[str]) -> None:
    before = signal.getsignal(signal.SIGINT)
    assert failing(KeyboardInterrupt())([]) == 130
    assert capsys.readouterr() == ("", "rtfail: interrupted\n")
    assert signal.getsignal(signal.SIGINT) is before


def test_wrong_arguments_show_the_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert failing(WrongArguments("too few"))([]) == 1
    assert capsys.readouterr().err == "Usage: rtfail [OPTIONS]\nrtfail: too few\n"


def test_arguments_that_nobody_takes(capsys: pytest.CaptureFixture[str]) -> None:
    assert failing(Refused(""))(["x\x1b"]) == 2
    told = "Usage: rtfail [OPTIONS]\nrtfail: Got unexpected extra argument (x\\x1b)\n"
    assert capsys.readouterr().err == told


@pytest.mark.parametrize("name", COMMANDS.values())
def test_common_options(run: Run, name: str) -> None:
    assert run(f"{name} --version") == (0, f"rtkit {__version__}\n", "")
    for option in ("-h", "--help"):
        outcome = run(f"{name} {option}")
        assert outcome.status == 0
        assert outcome.out.startswith(f"Usage: {name} [OPTIONS]")
        assert outcome.err == ""
    assert run(f"{name} --timeout 0").status == 2
    assert run(f"{name} --timeout soon").status == 2


@pytest.mark.parametrize("name", COMMANDS.values())
def test_help_tells_what_may_be_repeated_and_what_holds_otherwise(name: str) -> None:
    main = load(name)
    options = [each for each in main.command.params if isinstance(each, click.Option)]
    for each in (each for each in options if not (each.is_flag or each.count)):
        told = each.help or ""
        assert ("repeatable" in told) == each.multiple, told
        has_default = isinstance(each.default, str | int | float) and each.default != ""
        assert each.multiple or "default" in told.lower() or not has_default, told


def test_the_time_out_reaches_the_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = {}

    def connect(manager: str = "", timeout_s: float = 0.0) -> Any:
        asked["timeout_s"] = timeout_s
        raise Unreachable("nobody")

    monkeypatch.setattr("rtkit.tree.connect.connect", connect)
    from rtkit.cli.tree.rtls import main

    assert main(["--timeout", "2.5"]) == 1
    assert asked == {"timeout_s": 2.5}


def test_a_connection_made_here_is_closed_and_one_handed_in_is_not() -> None:
    class Tree:
        is_closed = False

        def close(self) -> None:
            self.is_closed = True

    @command("rtuse")
    def main(app: App) -> None:
        if app._tree is None:
            app._tree = own  # type: ignore[assignment]

    own, given = Tree(), Tree()
    assert main([], tree=given) == 0  # type: ignore[arg-type]
    assert not given.is_closed
    assert main([]) == 0
    assert own.is_closed


def test_a_reader_that_leaves_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    script = (
        "import sys\n"
        "from rtkit.cli.shared.command import command\n"
        "import click\n"
        "@command('rtmuch')\n"
        "def main(app):\n"
        "    for _ in range(100000): click.echo('x' * 50)\n"
        "sys.exit(main())\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 141


@pytest.mark.parametrize(
    ("arguments", "body", "status"),
    [("['-h']", "pass", 1), ("[]", "print('x')", 1), ("[]", "pass", 0)],
)
def test_a_closed_stdout_is_told_by_whoever_writes_to_it(
    arguments: str, body: str, status: int
) -> None:
    script = (
        "import sys; sys.stdout.close(); sys.stdout = None\n"
        "from rtkit.cli.shared.command import command\n"
        "@command('rtquiet')\n"
        f"def main(app): {body}\n"
        f"sys.argv = ['rtquiet', *{arguments}]\n"
        "sys.exit(main())\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    told = b"rtquiet: Bad file descriptor\n" if status else b""
    assert (done.returncode, done.stderr) == (status, told)


def test_a_full_disk_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    script = (
        "import sys\n"
        "from rtkit.cli.shared.command import command\n"
        "@command('rtfull')\n"
        "def main(app): print('x')\n"
        "sys.argv = ['rtfull']\n"
        "status = main()\n"
        "sys.stdout = None\n"
        "sys.exit(status)\n"
    )
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-c", script], stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert done.returncode == 1
    assert done.stderr.startswith(b"rtfull: No space left on device\n")


@pytest.mark.usefixtures("interrupts")
def test_characters_that_the_output_lacks_are_escaped(monkeypatch: pytest.MonkeyPatch) -> None:
    ascii_only = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", ascii_only)
    console_process.prepare()
    terminal.write(["größe"])
    ascii_only.flush()
    assert ascii_only.buffer.getvalue() == b"gr\\xf6\\xdfe\n"  # type: ignore[attr-defined]


def test_every_error_knows_its_kind() -> None:
    assert issubclass(UsageProblem, RtkitError)
    assert len(COMMANDS) == len(set(COMMANDS.values()))


@pytest.mark.parametrize("typed", ["nan", "inf", "1e400"])
@pytest.mark.parametrize("line", ["rtls --timeout", "rtwait -t", "rtlog -x", "rtls --watch"])
def test_numbers_are_finite(run: Run, line: str, typed: str) -> None:
    outcome = run(f"{line}={typed} x" if "--" in line else f"{line} {typed} x")
    assert outcome.status == 2
    assert f"{typed!r} is not a finite number." in outcome.err
