"""Runs of Bug navigation: deployed by plans, waited for, and written down.

Each run is one deployment of ``system.yaml``. The plan from the one before is the cheapest: another
variant is set while its component is inactive, other sensors are another adaptor.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise, product
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, NamedTuple

import rtkit
from rtkit.errors import InvalidDocument, NotFound, Refused, RtkitError

from . import assembly
from .assembly import Assembly, variants
from .environments import Environment, bound, read_environments, shipped, shortest
from .pictures import multiples_svg, rendered, run_svg
from .records import (
    FOLLOW,
    GOAL,
    Choice,
    Record,
    Row,
    result_json,
    table_csv,
    table_md,
    trajectory_csv,
    write,
)
from .records import line_of as line_of
from .records import result_of as result_of

if TYPE_CHECKING:
    from .messages import Outcome, PathRow

FOLDER = Path(__file__).resolve().parent
SYSTEM = FOLDER / "system.yaml"
SENSORS = {
    "laser": "180 degrees ahead, 0.02 m to 4 m, a beam for each degree",
    "ir": "three infra-red cones of 26 degrees, up to 2 m: ahead, left, right",
    "laser+ir": "both",
    "bumper": "six contact switches of 60 degrees",
}
"""What each set of sensors is."""
DIRECTIONS = ("left", "right")
PAPER = (
    ("closed", "one-box", "visited"),
    ("bug1", "bug2", "alg1", "alg2", "distbug", "tangentbug", "rev1"),
    ("laser", "ir"),
)
"""Worlds, variants and sensors of the paper: 42 runs."""
STEP_LIMIT = 20000
_ATTEMPTS = 3
_NAME = re.compile(r"\w[\w.+-]*")
_LOOK_S, _DRAWN_S = 0.5, 0.1
_SHOWN_S = 2.0
_CHUNK = 2000
Notify = Callable[[str], object]


class Options(NamedTuple):
    """How runs are done.

    Attributes:
        files: Files of further worlds.
        speedup: How many times as fast as real time; 0 for no waiting.
        noise: Sigma of ranges and odometry [m].
        step_limit: After so many control steps a run is given up.
        prefix: Before the names of all components.
    """

    files: tuple[str, ...] = ()
    speedup: float = 0.0
    noise: float = 0.0
    step_limit: int = STEP_LIMIT
    prefix: str = ""


class Variant(NamedTuple):
    """A variant: the value of the parameter that chooses it, and its assembly."""

    value: str
    assembly: Assembly


def read_worlds(files: Sequence[str]) -> dict[str, Environment]:
    """Return the shipped worlds and those of files by name; a later one wins.

    Raises:
        NotFound: A file cannot be read.
        InvalidDocument: One does not fit; the message has the place.
        Refused: Its name cannot be handed on.
    """
    worlds = shipped()
    for file in files:
        if ":" in file:
            raise Refused(f"{file}: a file of worlds cannot have : in its name")
        found = read_environments(_text(file), file)
        _check_names(file, "world", found)
        worlds |= found
    return worlds


def read_variants(files: Sequence[str]) -> dict[str, Variant]:
    """Return the shipped variants and those of files by name; a later one wins.

    Raises:
        NotFound: A file cannot be read.
        InvalidDocument: It is no UTF-8, or a name is none.
        Refused: An assembly cannot work; one sentence says why.
    """
    known = {name: Variant(name, each) for name, each in variants().items()}
    for file in files:
        text = _text(file)
        found = assembly.read_variants(text, file)
        _check_names(file, "variant", found)
        data = json.loads(text)
        known |= {name: Variant(json.dumps(data[name]), each) for name, each in found.items()}
    return known


def _text(file: str) -> str:
    try:
        return Path(file).read_text("utf-8")
    except OSError as error:
        raise NotFound(f"{file}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InvalidDocument(f"{file}: it is no UTF-8: {error.reason}") from None


def _check_names(file: str, what: str, names: Iterable[str]) -> None:
    for name in names:
        if not _NAME.fullmatch(name):
            why = f"a {what}'s name has letters, digits, _ . + -"
            raise InvalidDocument(f"{file}: {name!r}: {why}")


def combinations(
    worlds: Sequence[str],
    names: Sequence[str],
    sensors: Sequence[str],
    directions: Sequence[str],
    seed: int,
) -> list[Choice]:
    """Return the runs of all combinations, each once; neighbours differ in as little as may be."""
    found = [
        Choice(world, variant, each, direction, seed)
        for each, world, direction, variant in product(sensors, worlds, directions, names)
    ]
    return list(dict.fromkeys(found))


class Runner:
    """Deploys runs at a manager, one after the other.

    Args:
        tree: The connection to the manager.
        worlds: Worlds by name.
        known: Variants by name.
        options: How runs are done.
        notify: Receives progress, a line each.
        look: Is called now and then while a run is under way, and when it is over.
    """

    def __init__(
        self,
        tree: rtkit.Tree,
        worlds: Mapping[str, Environment],
        known: Mapping[str, Variant],
        options: Options,
        notify: Notify,
        look: Callable[[Runner, Choice], object] | None = None,
    ) -> None:
        self._tree = tree
        self._worlds = worlds
        self._options = options
        self._notify = notify
        self._look = look
        self._variants = known

    def run(self, choice: Choice) -> Record:
        """Do a run to its end; where a component is lost on the way, from its beginning again.

        Raises:
            Refused: That happened three times.
        """
        why = ""
        for _ in range(_ATTEMPTS):
            if why:
                self._notify(f"{choice}: {why}; the run begins again")
            try:
                self._deploy(choice, is_anew=bool(why))
                why = self._wait(choice)
                if not why:
                    return self._record(choice)
            except RtkitError:
                why = self._sick_soon()
                if not why:
                    raise
        raise Refused(f"{choice}: {why} ({_ATTEMPTS} times)")

    def outcome(self) -> Outcome:
        """Return how the run under way is."""
        return self._tree.call(f"{self._robot}:record.outcome")

    def rows(self, first: int) -> list[PathRow]:
        """Return the rows of the run under way from one on."""
        found: list[PathRow] = []
        while True:
            more = self._tree.call(f"{self._robot}:record.rows", first + len(found), _CHUNK)
            found += more
            if len(more) < _CHUNK:
                return found

    @property
    def _robot(self) -> str:
        return f"/localhost/{self._options.prefix}MobileRobot0.rtc"

    def _deploy(self, choice: Choice, *, is_anew: bool) -> None:
        """Make the live system that of a run; show the plan."""
        environment, options = self._worlds[choice.environment], self._options
        values = {
            **choice._asdict(),
            "world": choice.environment,
            "variant": self._variants[choice.variant].value,
            "run": f"{choice}-{choice.seed}",
            "goal": "{!r},{!r}".format(*environment.goal),
            "goal_margin": environment.goal_margin,
            "speedup": options.speedup,
            "noise": options.noise,
            "step_limit": options.step_limit,
            "environments": ":".join(str(Path(file).resolve()) for file in options.files),
        }
        del values["environment"]
        profile = rtkit.load(SYSTEM, values=values, prefix=options.prefix)
        if is_anew:
            self._tree.stop(profile)
        plan = self._tree.plan(profile, prune=True)
        kinds = Counter(step.partition(" ")[0] for step in plan.steps)
        told = ", ".join(f"{kind} {count}" for kind, count in kinds.items())
        self._notify(f"{choice}: {len(plan)} steps: {told}")
        plan.apply()

    def _wait(self, choice: Choice) -> str:
        """Wait until the run is over; return why it will not be, empty when it is."""
        name = f"{self._options.prefix.replace('.', '/')}MobileRobot0.status"
        label = f"{choice}-{choice.seed}"
        period_s = _LOOK_S if self._look is None else _DRAWN_S
        while True:
            for change in self._tree.properties.listen(name, timeout_s=period_s):
                if change.value:
                    break
            if self._look is not None:
                self._look(self, choice)
            outcome = self.outcome()
            if outcome.status and outcome.run == label:
                return ""
            why = self._sick()
            if why:
                return why

    def _sick(self) -> str:
        """Return which component is lost or in Error, and why; empty if all are well."""
        for each in self._tree.snapshot().components:
            if not each.instance.startswith(self._options.prefix):
                continue
            if each.zombie:
                return f"{each.instance} has ended ({each.zombie})"
            if each.state == "Error":
                return f"{each.instance} is in Error ({each.cause})"
        return ""

    def _sick_soon(self) -> str:
        """Return the same; a component that was lost just now is shown so a moment later."""
        until = monotonic() + _SHOWN_S
        while not (why := self._sick()) and monotonic() < until:
            sleep(_SHOWN_S / 20)
        return why

    def _record(self, choice: Choice) -> Record:
        """Return what a run has left behind."""
        outcome, kept = self.outcome(), self.rows(0)
        has_noise = self._options.noise > 0
        rows = [
            Row(
                row.t,
                row.x,
                row.y,
                row.theta,
                row.mode,
                (row.odom_x, row.odom_y, row.odom_theta) if has_noise else None,
            )
            for row in kept
        ]
        changes = [(a.mode, b.mode, (b.x, b.y)) for a, b in pairwise(rows)]
        environment = self._worlds[choice.environment]
        assembly = self._variants[choice.variant].assembly
        return Record(
            choice=choice,
            environment=environment,
            status=outcome.status,
            rows=rows,
            hits=[place for a, b, place in changes if (a, b) == (GOAL, FOLLOW)],
            leaves=[place for a, b, place in changes if (a, b) == (FOLLOW, GOAL)],
            reversals=outcome.reversals,
            collisions=outcome.collisions,
            min_clearance=outcome.min_clearance,
            has_line=assembly.motion == "m-line",
            shortest=shortest(environment),
            bound=bound(environment, assembly),
        )


def check_writable(out: Path) -> None:
    """Make a folder, and try whether files can be written into it.

    Raises:
        Refused: They cannot.
    """
    try:
        write(out, ".rtbug", "")
        (out / ".rtbug").unlink()
    except OSError as error:
        raise Refused(f"{out}: nothing can be written there: {error.strerror}") from None


def write_run(out: Path, record: Record) -> None:
    """Write the files of a run; with ``result.json``, the last one, its folder is complete.

    Raises:
        Refused: They cannot be written.
    """
    folder = out / record.choice.folder
    try:
        (folder / "result.json").unlink(missing_ok=True)
        write(folder, "trajectory.csv", trajectory_csv(record.rows))
        write(folder, "trajectory.svg", run_svg(record))
        rendered(folder / "trajectory.svg")
        write(folder, "result.json", result_json(record))
    except OSError as error:
        raise Refused(f"{folder}: {error.strerror}") from None


def write_tables(out: Path, records: Sequence[Record]) -> None:
    """Write the tables of a call, and a picture of all runs of each world.

    Raises:
        Refused: They cannot be written.
    """
    by_world: dict[str, list[Record]] = {}
    for record in records:
        by_world.setdefault(record.choice.environment, []).append(record)
    try:
        for world, of_world in by_world.items():
            write(out, f"{world}.svg", multiples_svg(of_world))
            rendered(out / f"{world}.svg")
        write(out, "table.csv", table_csv(records))
        write(out, "table.md", table_md(records))
    except OSError as error:
        raise Refused(f"{out}: {error.strerror}") from None
