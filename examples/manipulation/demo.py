"""Plays dialogues with the manipulator, killing it on the way: ``make demo-manipulation``.

Runs the installed commands as an operator would, in folders of its own, and checks what they show;
the exit status is 0 only when everything was as it must be and nothing is left. At the end it
writes the pictures of what was planned into the folder that is named, else ``build/manipulation``.
"""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

HERE = Path(__file__).resolve().parent
PICTURES = ("site", "explored", "way", "tree")
PATIENCE_S = 30.0


class NotAsExpected(Exception):
    """The demo did not go as it must."""


class Operator:
    """Types commands, each shown with its answer.

    Attributes:
        folder: Of runtime, state and logs.
        out: Where pictures go.
    """

    def __init__(self, folder: Path, out: Path) -> None:
        self.folder, self.out = folder, out
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
        self.environment = {
            **os.environ,
            "PATH": path,
            "RTKIT_RUNTIME_DIR": str(folder / "run"),
            "RTKIT_STATE_DIR": str(folder / "state"),
            "RTKIT_MODULE_PATH": str(HERE),
            "RTKIT_PORT": "none",
            "RTKIT_MANAGER": "manager",
            "RTKIT_CWD": "/",
        }

    def run(self, *command: str, is_shown: bool = False) -> str:
        """Run one command; return what it prints."""
        if is_shown:
            print(f"$ {shlex.join(command)}")
        done = subprocess.run(
            command,
            env=self.environment,
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=60,
        )
        if done.returncode:
            raise NotAsExpected(f"{' '.join(command)}: {done.stderr}")
        if is_shown and done.stdout.strip():
            print(done.stdout.rstrip(), flush=True)
        return done.stdout.strip()

    def get(self, name: str) -> str:
        """Return a property of the desk."""
        return self.run("rtget", "--raw", f"table.{name}")

    def say(self, sentence: str, expected: str = "") -> None:
        """Say a sentence and print the answer."""
        self.run("rtset", "table.command", sentence, is_shown=True)
        self.hear(expected)

    def hear(self, expected: str = "") -> None:
        """Print what the supervisor said last, which must hold a text."""
        said = self.get("said")
        print(f"  {said}", flush=True)
        if expected not in said:
            raise NotAsExpected(f"expected {expected!r}, found {said!r}")

    def answer(self, text: str, expected: str = "") -> None:
        """Answer the question that is open."""
        found = re.search(r"\(\((q\d+)", self.run("rtget", "table.questions.open"))
        if found is None:
            raise NotAsExpected("no question is open")
        for line in self.get(f"questions.{found[1]}.details").splitlines()[:4]:
            print(f"    {line}")
        self.run("rtset", f"table.questions.{found[1]}", text, is_shown=True)
        self.hear(expected)

    def until(self, name: str, value: str) -> None:
        """Wait until a property has a value."""
        deadline = time.monotonic() + PATIENCE_S
        while self.get(name) != value:
            if time.monotonic() > deadline:
                raise NotAsExpected(f"{name} was never {value}")
            time.sleep(0.05)

    def draw(self, scene: str, *which: str) -> None:
        """Keep pictures."""
        self.out.mkdir(parents=True, exist_ok=True)
        for name in which or PICTURES:
            file = self.out / f"{scene}-{name}.svg"
            file.write_text(self.get(f"picture.{name}") + "\n", encoding="utf-8")

    def kill(self, slave: str) -> None:
        """Kill a slave, and wait until its component is made again."""
        shown = self.run("rtcat", f"/localhost/manager.mgr/{slave}.mgr")
        found = re.search(r"Process ID: (\d+)", shown)
        if found is None:
            raise NotAsExpected(f"no process id in {shown}")
        print(f"$ kill -9 {found[1]}   # the supervisor")
        os.kill(int(found[1]), signal.SIGKILL)
        deadline = time.monotonic() + PATIENCE_S
        while "made again" not in self.run("rtls", "-l", "/localhost"):
            if time.monotonic() > deadline:
                raise NotAsExpected("it was not made again")
            time.sleep(0.05)
        self.run("rtwait", "-t", "20", "/localhost/Supervisor0.rtc", "active")


def tell(text: str) -> None:
    """Say what comes next."""
    print(f"\n# {text}", flush=True)


@contextmanager
def system(operator: Operator, site: str, speed: float = 2.0) -> Iterator[None]:
    """Bring the two components up at a site; end them afterwards."""
    values = (f"site={site}", f"speed={speed}", f"memory={operator.folder / site}.json")
    sets = [word for value in values for word in ("--set", value)]
    operator.run("rtmgr", "start")
    try:
        operator.run("rtapply", *sets, str(HERE / "system.yaml"), is_shown=True)
        yield
    finally:
        operator.run("rtmgr", "stop")


def doorway(operator: Operator) -> None:
    """Clear a doorway, and be killed on the way."""
    tell("A doorway two places high; the tall A is to pass, B1 and B2 stand in it.")
    with system(operator, "doorway", 0.6):
        operator.say("designate object at (3 3) (3 4) A")
        operator.say("designate object at (6 4) B1")
        operator.say("designate object at (6 3) B2")
        operator.say("designate region at (5 1) (5 6) (4 1) (4 6) aside")
        operator.say("take A to (9 3)", "in the way to take A to (9 3): B1 and B2")
        operator.answer("aside", "a and b tie at 39")
        operator.draw("doorway")
        operator.answer("b")
        operator.until("holding", "B1")
        operator.kill("supervisor")
        operator.run("rtconf", "/localhost/Manipulator0.rtc", "set", "speed", "3")
        operator.until("state", "idle")
        operator.hear("take A to (9 3): done, cost 39")
        print(operator.get("site"))


def switch(operator: Operator) -> None:
    """Define a command, use it, and see it remembered."""
    tell("Two objects change places, by a command that the operator defines.")
    with system(operator, "switch", 5.0):
        operator.say("designate object at (3 4) A")
        operator.say("designate object at (7 4) B")
        operator.say("designate region at (4 5) (5 5) (6 5) X")
        operator.say("designate region at (4 4) (6 4) Y")
        body = "take A to X; go to Y; take B to where A was; take A to where B was"
        operator.say(f"define switch A B X Y = {body}", "defined switch A B X Y")
        operator.say("switch A B X Y", "a and b and c and d tie at 31")
        operator.draw("switch")
        before = operator.get("evaluations")
        operator.say("cancel")
        operator.say("switch A B X Y", "tie at 31")
        if operator.get("evaluations") != before:
            raise NotAsExpected("what was solved before was searched again")
        tell(f"Solved before: still {before} evaluations. Now with carrying as cheap as moving:")
        operator.run("rtset", "table.prices.carry", "1", is_shown=True)
        operator.hear("tie at 21")
        operator.answer("c")
        operator.until("state", "idle")
        operator.hear("done, cost 21")
    tell("The manager ends and starts again: everything is still known.")
    with system(operator, "switch", 5.0):
        operator.run("rtget", "table.definitions.switch", "table.results", is_shown=True)


def room(operator: Operator) -> None:
    """Find a thing that nobody told of."""
    tell("A room with two doors: leave the red block near the light switch.")
    with system(operator, "room", 3.0):
        operator.say("designate object at (3 3) red block")
        operator.say("designate place at (10 7) light switch")
        operator.say("designate region at (5 3) door")
        operator.say("pick up the red block")
        operator.until("holding", "red block")
        operator.say("leave it near the light switch", "ways to leave it near the light switch")
        operator.run("rtset", "table.risks.door", "9", is_shown=True)
        operator.hear("ways to leave it near the light switch")
        operator.run("rtset", "table.risks.door", "0", is_shown=True)
        operator.draw("room")
        operator.answer("a")
        operator.until("state", "stopped")
        operator.hear("something is at")
        operator.draw("felt", "site")
        operator.answer("box", "")
        operator.until("state", "idle")
        operator.hear("done")
        print(operator.get("site"))


def main(out: str = "build/manipulation") -> int:
    """Play the demo; return its exit status."""
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="rtm") as name:
        folder = Path(name)
        for each in ("run", "state"):
            (folder / each).mkdir(mode=0o700)
        operator = Operator(folder, Path(out).resolve())
        try:
            for scene in (doorway, switch, room):
                scene(operator)
            if list((folder / "run").iterdir()):
                raise NotAsExpected("something is left in the runtime folder")
        except NotAsExpected as surprise:
            print(f"\ndemo: not as expected: {surprise}", file=sys.stderr)
            return 1
    tell(f"Pictures are in {operator.out}. That took {time.monotonic() - begin:.1f} s.")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
