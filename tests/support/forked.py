"""Runs commands as forks of one process that has imported them all: real ones, only quicker.

Read as a script it takes a JSON object a line, ``{"argv": …, "text": …, "is_endless": …}``, which
may name a ``folder`` and an ``environment`` to run in. It answers with ``{"status": …, "out": …,
"err": …}``. An endless command is interrupted, as by Ctrl-C, once it has written something, or when
it has nothing to write.
"""

from __future__ import annotations

import json
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

_LONGEST_S = 50.0
_QUIET_S = 1.5


class Commands:
    """The other end of that process."""

    def __init__(self, environment: Mapping[str, str], folder: Path) -> None:
        self._environment = dict(environment)
        self._folder = folder
        self._process = self._begin()

    def _begin(self) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, __file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=self._environment,
            cwd=self._folder,
            process_group=0,
        )

    def run(
        self, argv: list[str], text: str = "", *, is_endless: bool = False, **place: Any
    ) -> dict[str, Any]:
        """Run a command, in an `environment` and a `folder` of its own if `place` names them.

        Return its status and what it wrote.
        """
        asked = {"argv": argv, "text": text, "is_endless": is_endless, **place}
        if self._process.poll() is not None:
            self._begin_anew()
        try:
            return self._ask(asked)
        except BaseException:
            # A test whose time is up leaves an answer that the next one would take for its own.
            self._begin_anew()
            raise

    def _begin_anew(self) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        with suppress(BrokenPipeError):
            self.close()
        self._process = self._begin()

    def _ask(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(asked) + "\n")
        self._process.stdin.flush()
        told: dict[str, Any] = json.loads(self._process.stdout.readline())
        return told

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


def serve() -> None:
    """Answer requests until there are no more."""
    from rtkit.cli.shared.commands import COMMANDS, load

    for name in COMMANDS.values():
        load(name)
    import rtkit.link.zenoh
    import rtkit.tree.client  # noqa: F401

    for line in sys.stdin:
        asked = json.loads(line)
        print(json.dumps(_answer(**asked)), flush=True)


def _answer(argv: list[str], text: str, is_endless: bool, **place: Any) -> dict[str, Any]:
    given = os.memfd_create("stdin")
    os.write(given, text.encode())
    os.lseek(given, 0, os.SEEK_SET)
    pipes = [os.pipe(), os.pipe()]
    pid = os.fork()
    if pid == 0:
        if place:
            os.environ.clear()
            os.environ.update(place["environment"])
            os.chdir(place["folder"])
        _become(argv, given, pipes)
    os.close(given)
    for _, end in pipes:
        os.close(end)
    out, err = _read(pid, [begin for begin, _ in pipes], is_endless)
    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    return {"status": status, "out": out, "err": err}


def _become(argv: list[str], given: int, pipes: list[tuple[int, int]]) -> None:
    for target, source in ((0, given), (1, pipes[0][1]), (2, pipes[1][1])):
        os.dup2(source, target)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # What the parent has buffered and where it stands is not of this process.
    sys.stdin, sys.stdout = open(0, closefd=False), open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", buffering=1, closefd=False)  # noqa: SIM115
    sys.argv = argv
    from rtkit import cli
    from rtkit.cli.shared.commands import load

    sys.exit(cli.main() if argv[0] == "rtkit" else load(argv[0])())


def _read(pid: int, ends: list[int], is_endless: bool) -> list[str]:
    texts = dict.fromkeys(ends, b"")
    until = time.monotonic() + (_QUIET_S if is_endless else _LONGEST_S)
    with selectors.DefaultSelector() as selector:
        for end in ends:
            selector.register(end, selectors.EVENT_READ)
        while selector.get_map():
            ready = selector.select(max(0.0, until - time.monotonic()))
            for key, _ in ready:
                piece = os.read(key.fd, 65536)
                texts[key.fd] += piece
                if not piece:
                    selector.unregister(key.fd)
                    os.close(key.fd)
            if (is_endless and any(texts.values())) or not ready:
                is_endless, until = False, time.monotonic() + 60.0
                os.kill(pid, signal.SIGINT)
    return [texts[end].decode(errors="replace") for end in ends]


if __name__ == "__main__":
    serve()
