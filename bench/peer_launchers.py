"""Runs supervisord and dora, and launches processes by their commands."""

from __future__ import annotations

import os
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from bench.peer_packages import PeerMissing
from rtkit.link.tcp_endpoint import free_port

ENDS = str(Path(__file__).with_name("peer_ends.py"))
_PATIENCE_S = 30.0
_SUPERVISED = """\
[unix_http_server]
file={place}/socket
[supervisord]
logfile={place}/log
pidfile={place}/pid
[rpcinterface:supervisor]
supervisor.rpcinterface_factory = supervisor.rpcinterface:make_main_rpcinterface
[supervisorctl]
serverurl=unix://{place}/socket
[program:n]
command={python} {ends} speak {place}
process_name=n%(process_num)d
numprocs={count}
autostart=false
startsecs=0
"""


class Heard:
    """Datagrams by which processes tell that they live."""

    def __init__(self, place: str) -> None:
        self._end = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._end.bind(f"{place}/up")
        self._end.settimeout(_PATIENCE_S)

    def texts(self, count: int) -> list[str]:
        """Wait for so many."""
        try:
            return [self._end.recv(64).decode() for _ in range(count)]
        except TimeoutError:
            raise PeerMissing(f"{count} processes did not start in {_PATIENCE_S:g} s") from None

    def close(self) -> None:
        """Hear no more."""
        self._end.close()


def run(words: Sequence[str], folder: str) -> None:
    """Run a command of another system, at home in a folder."""
    done = _finished(words, folder)
    if done.returncode:
        told = (done.stderr or done.stdout).strip().splitlines() or ["it told no reason"]
        raise PeerMissing(f"{' '.join(words[:2])}: {told[-1]}")


def _finished(words: Sequence[str], folder: str) -> subprocess.CompletedProcess[str]:
    home = {**os.environ, "HOME": folder}
    return subprocess.run(
        words, capture_output=True, check=False, text=True, cwd=folder, env=home,
        timeout=_PATIENCE_S,
    )  # fmt: skip


@contextmanager
def supervisord(programs: Path, count: int) -> Iterator[Callable[[], float]]:
    """Run supervisord; yield what launches processes by one command until all live [ms]."""
    with tempfile.TemporaryDirectory(prefix="rtb") as place, ExitStack() as stack:
        heard = Heard(place)
        stack.callback(heard.close)
        file = Path(place, "conf")
        python = programs / "python"
        text = _SUPERVISED.format(place=place, python=python, ends=ENDS, count=count)
        file.write_text(text, encoding="utf-8")
        _background(stack, [str(programs / "supervisord"), "-n", "-c", str(file)], place)
        control = [str(programs / "supervisorctl"), "-c", str(file)]
        _until(lambda: _finished([*control, "pid"], place).returncode == 0, "supervisord")

        def launch_ms() -> float:
            begin = time.perf_counter()
            run([*control, "start", "n:*"], place)
            heard.texts(count)
            elapsed_ms = (time.perf_counter() - begin) * 1e3
            run([*control, "stop", "n:*"], place)
            return elapsed_ms

        yield launch_ms


class Dora:
    """A coordinator and a daemon of dora, and flows that they run."""

    def __init__(self, programs: Path, stack: ExitStack) -> None:
        self._programs = programs
        self.place = stack.enter_context(tempfile.TemporaryDirectory(prefix="rtb"))
        self.heard = Heard(self.place)
        stack.callback(self.heard.close)
        port = str(free_port())
        self._coordinator = ["--coordinator-port", port]
        store = ["--store", "memory", "--quiet"]
        self._start(stack, "coordinator", "--port", port, *store)
        local = ["--local-listen-port", str(free_port()), "--quiet"]
        self._start(stack, "daemon", *self._coordinator, *local)
        _until(self._is_up, "dora")

    def launch_ms(self, count: int) -> float:
        """Launch nodes by one command, until all have told that they live [ms]."""
        nodes = [_node(f"n{index}", f"{self._programs}/python", f"dora-speak {self.place}")
                 for index in range(count)]  # fmt: skip
        begin = time.perf_counter()
        self.start("".join(nodes))
        self.heard.texts(count)
        elapsed_ms = (time.perf_counter() - begin) * 1e3
        self.stop()
        return elapsed_ms

    def start(self, nodes: str) -> None:
        """Start a flow of nodes."""
        file = Path(self.place, "flow.yml")
        file.write_text(f"nodes:\n{nodes}", encoding="utf-8")
        self._do("start", str(file), "--detach", "--name", "flow")

    def stop(self) -> None:
        """End it."""
        self._do("stop", "flow")

    @contextmanager
    def trips(self, size: int, count: int) -> Iterator[tuple[Callable[[], float], tuple[int, int]]]:
        """Run two nodes; yield what measures so many round trips [us], and their process ids."""
        self.start(self._trip_nodes(size))
        told = dict(text.split() for text in self.heard.texts(2))
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as end:
            end.connect(f"{self.place}/ask")

            def measure() -> float:
                end.send(str(count).encode())
                return float(self.heard.texts(1)[0])

            try:
                yield measure, (int(told["ping"]), int(told["echo"]))
            finally:
                end.send(b"0")
                self.stop()

    def _trip_nodes(self, size: int) -> str:
        python = f"{self._programs}/python"
        words = {role: f"dora {role} {self.place} {size}" for role in ("ping", "echo")}
        return _node("ping", python, words["ping"], "there", "echo/back") + _node(
            "echo", python, words["echo"], "back", "ping/there"
        )

    def _do(self, verb: str, *words: str) -> None:
        run([str(self._programs / "dora"), verb, *words, *self._coordinator], self.place)

    def _is_up(self) -> bool:
        words = [str(self._programs / "dora"), "status", *self._coordinator]
        done = _finished(words, self.place)
        return done.returncode == 0

    def _start(self, stack: ExitStack, *words: str) -> None:
        _background(stack, [str(self._programs / "dora"), *words], self.place)


def _node(name: str, python: str, words: str, output: str = "", source: str = "") -> str:
    wires = f"    outputs: [{output}]\n    inputs: {{it: {source}}}\n" if output else (
        "    inputs: {tick: dora/timer/secs/60}\n"
    )  # fmt: skip
    return f"  - id: {name}\n    path: {python}\n    args: {ENDS} {words}\n{wires}"


def _background(stack: ExitStack, words: Sequence[str], folder: str) -> None:
    home = {**os.environ, "HOME": folder}
    nothing = subprocess.DEVNULL
    process = subprocess.Popen(words, stdout=nothing, stderr=nothing, cwd=folder, env=home)
    stack.callback(process.wait)
    stack.callback(process.terminate)


def _until(is_so: Callable[[], bool], name: str) -> None:
    deadline = time.monotonic() + _PATIENCE_S
    while not is_so():
        if time.monotonic() > deadline:
            raise PeerMissing(f"{name} did not start in {_PATIENCE_S:g} s")
