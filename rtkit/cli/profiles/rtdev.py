"""``rtdev``: keep a live system as its sources say, while they are written."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from rtkit.api.planning import GoalOptions
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, json_flag, together
from rtkit.cli.system import shared
from rtkit.cli.system.document import read_document
from rtkit.cli.system.planning import AIM
from rtkit.errors import InvalidDocument, Malformed, NotFound, Refused, RtkitError

if TYPE_CHECKING:
    from rtkit.api.planning import Prepared
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.system import WantedSystem


@command(
    "rtdev",
    examples=(
        ("rtdev robot.xml", "Apply a profile, and again what is saved, until Ctrl-C."),
        ("rtdev -s inactive robot.xml", "Activate nothing."),
    ),
    json=("development",),
)
def main(
    app: App,
    is_down: bool = flag("--down", "End the components of the profile at the end."),
    is_json: bool = json_flag("A JSON object for each thing that happens, also for errors."),
    wait_s: float = shared.WAIT,
    aim: GoalOptions = AIM,
    asked: shared.DocumentOptions = together(shared.DocumentOptions),
) -> int:
    """Apply an RTS profile, and again what is saved, until Ctrl-C.

    Watched are FILE, what it includes, files of --values, the modules of its components, what these
    import from beside them, and other sources beside all these. Each save becomes the smallest
    plan, which is shown and carried out as by rtapply: of a changed parameter only that is set. Of
    a changed module only its components are made again, with all that shares a slave with them, and
    get their connections, values and states back. Components that are no more in FILE end. Types
    that rtbuild made of an IDL file are made anew.

    A file with a syntax error, or a module that does not import, is told with its line, and the
    system stays as it was.

    At Ctrl-C or SIGTERM the system runs on, unless --down is given; the exit status is 0 then. A
    component in the manager's own process gets new code only from rtmgr restart, one that is run by
    hand when it is started again.
    """
    from rtkit.cli.shared.signals import ended_by_sigterm

    if len(asked.files) != 1 or asked.files == ("-",):
        raise Malformed("One system profile has to be given, as a file.")
    development = _Development(app, asked, aim, wait_s, is_json=is_json)
    try:
        with ended_by_sigterm() as ended:
            development.run(ended.is_set)
    except KeyboardInterrupt as interrupt:
        if str(interrupt):
            app.fail(str(interrupt))
    app.close()
    if is_down:
        from rtkit.api.starting import teardown

        document = read_document(app, asked)
        teardown(app, document, ends_components=True, is_dry=False)
    else:
        app.report(f"the system runs on; rtteardown --exit {asked.files[0]} ends it")
    return 0


class _Development:
    """Applies a profile again and again."""

    def __init__(
        self,
        app: App,
        asked: shared.DocumentOptions,
        aim: GoalOptions,
        wait_s: float,
        *,
        is_json: bool,
    ) -> None:
        from rtkit.api.sources import SourceFiles

        self._app = app
        self._asked = asked
        self._aim = aim._replace(way=aim.way._replace(replaces=True))
        self._wait_s = wait_s
        self._sources = SourceFiles()
        self._before: WantedSystem | None = None
        self._files: Sequence[str] = asked.files
        self._is_changing = False
        self._is_json = is_json

    def run(self, is_ended: Callable[[], bool]) -> None:
        """Go on until it is ended.

        Raises:
            NotFound: There is no profile.
        """
        from rtkit.api.sources import PERIOD_S

        if not os.path.isfile(self._asked.files[0]):
            raise NotFound(f"no such file: {self._asked.files[0]}")
        self._sources.follow(self._files)
        self._try([])
        text = f"watching {len(self._files)} files; Ctrl-C ends that"
        self._report("watching", text, self._files)
        while not is_ended():
            self._app.wait_for([], time.monotonic() + PERIOD_S)
            saved = self._sources.saved()
            if saved:
                from rtkit.api.sources import shown

                self._report("saved", f"saved: {', '.join(map(shown, saved))}", saved)
                self._try(saved)

    def _try(self, saved: Sequence[str]) -> None:
        """Apply what was saved; tell why not, and whether that has changed the system."""
        self._is_changing = False
        try:
            self._check(saved)
            self._apply()
        except RtkitError as error:
            self._app.fail(str(error))
            if not self._is_changing:
                self._report("failed", "the system stays as it was", [str(error)])
            elif self._is_json:
                self._report("failed", "the system was changed in part", [str(error)])
        finally:
            self._app.close()  # the next manager of that name may be another one

    def _check(self, saved: Sequence[str]) -> None:
        """Check sources of code, and make types of IDL files anew.

        Raises:
            RtkitError: One is wrong; tells file and line.
        """
        from rtkit.api.sources import syntax_errors

        present = [file for file in saved if os.path.isfile(file)]
        found = list(syntax_errors(file for file in present if file.endswith(".py")))
        for text in found[:-1]:
            self._app.fail(text)
        if found:
            raise InvalidDocument(found[-1])
        for file in present:
            if file.endswith(".idl"):
                from rtkit.cli.profiles.project_changes import renew_types

                for path in renew_types(file):
                    self._report("written", f"written: {os.path.relpath(path)}", [path])

    def _apply(self) -> None:
        from rtkit.api import planning
        from rtkit.api.plan import carry_out
        from rtkit.deployment.planning.rendering import lines
        from rtkit.tree.plan_locks import PlanLocks

        app, asked = self._app, self._asked
        document = read_document(app, asked)
        with PlanLocks(" ".join([app.name, *asked.files]), self._wait_s, app.report) as lock:
            prepared = planning.prepare(app, document, self._aim, is_dry=False, lock=lock)
            system = prepared.goal.system
            self._follow(document, system, prepared.snapshot)
            prepared = _without_dropped(prepared, self._before)
            if not prepared.plan.moves:
                self._before = system
                self._report("nothing", "nothing to do: everything is as wanted")
                return
            _check_imports(prepared)
            plan = [*lines(prepared.plan, prepared.goal.costs)]
            if self._is_json:
                self._report("plan", plan[0], plan[1:])
            else:
                terminal.write_now(map(terminal.printable, plan))
            began = time.monotonic()
            self._is_changing, self._before = True, system
            unmet = carry_out(app, prepared)
            self._follow(document, system, app.tree.snapshot())
        done = "done, but for what is told above" if unmet else "done"
        self._report("done", f"{done} in {time.monotonic() - began:.2f} s", unmet)

    def _follow(self, document: SystemProfile, system: WantedSystem, snapshot: Snapshot) -> None:
        """Watch the profile, and what its components come from or will come from."""
        from rtkit.api.sources import files_of

        names = {component.instance for component in system.components}
        live = [each for each in snapshot.components if each.instance in names]
        wanted = _module_files(system, snapshot)
        profiles = document.resolved.files if document.resolved is not None else ()
        named = [*self._asked.files, *self._app.values, *profiles]
        self._files = list(dict.fromkeys(map(os.path.abspath, [*named, *files_of(live), *wanted])))
        self._sources.follow(self._files)

    def _report(self, event: str, text: str, lines: Sequence[str] = ()) -> None:
        line = terminal.printable(f"[{terminal.clock(time.time())}] {text}")
        if self._is_json:
            at = json_records.time_text(time.time_ns())
            fields = {"time": at, "event": event, "text": text, "lines": [*lines]}
            line = json_records.line("development", fields)
        terminal.write_now([line])


def _module_files(system: WantedSystem, snapshot: Snapshot) -> list[str]:
    """Return the files of modules that components will be made from, as far as they are found."""
    from rtkit.modules.search import Search
    from rtkit.rtc.create import readable_create
    from rtkit.rtc.profiles import split_module

    search = Search(snapshot.properties.get("manager.modules.load_path", "").split(","))
    found = []
    for component in system.components:
        path = split_module(component.module)[0]
        type_name = readable_create(component.create).implementation_id
        with suppress(NotFound, Refused):
            found.append(search.read(path or type_name).file)
    return found


def _check_imports(prepared: Prepared) -> None:
    """Import the modules that have changed, before components of them end.

    Raises:
        Refused: One does not import; says where.
    """
    from rtkit.api.sources import check_imports, files_of
    from rtkit.rtc.profiles import split_module

    _, goal, snapshot, *_ = prepared
    modules = {each.instance: split_module(each.module)[1] for each in goal.system.components}
    check_imports(
        (files_of([facts])[0], modules[facts.instance])
        for facts in snapshot.components
        if facts.instance in modules and facts.changed_code(goal.feasibility.code)
    )


def _without_dropped(prepared: Prepared, before: WantedSystem | None) -> Prepared:
    """Return a plan that also ends what was in the profile when it was applied last."""
    from rtkit.deployment.planning.deployment_plan import make_plan
    from rtkit.fast_dataclass import replace

    goal = prepared.goal
    names = {each.instance for each in goal.system.components}
    ids = {each.profile.connector_id for each in goal.system.connectors}
    components = (
        [each for each in before.components if each.instance not in names] if before else []
    )
    dropped = {each.profile.connector_id for each in before.connectors} - ids if before else set()
    if not (components or dropped):
        return prepared
    system = replace(goal.system, components=(*goal.system.components, *components))
    absent = frozenset(each.instance for each in components)
    goal = replace(goal, system=system, absent=absent, dropped=frozenset(dropped))
    survey = goal.survey(prepared.snapshot)
    plan = make_plan(survey.model, goal.ranks)
    return prepared._replace(goal=goal, plan=plan, survey=survey)
