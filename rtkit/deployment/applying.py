"""Carries out a deployment plan, layer by layer, and takes a snapshot before each layer.

A step whose effect holds already is skipped. Where the world differs from the plan, the rest is
planned again from the present state. When a step fails, no further step begins: the applier
reports what is left, or plans a rollback from what lives then.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

from rtkit.deployment.actions import Action
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.goal import DeploymentGoal
from rtkit.deployment.layered_plan import Layer, LayeredPlan
from rtkit.deployment.live_index import LiveIndex
from rtkit.deployment.multi_manager import homes_in
from rtkit.deployment.plan_watch import BEGUN, DONE, FAILED, HELD, PlanWatch
from rtkit.deployment.planning.deployment_plan import DeploymentPlan, make_plan
from rtkit.deployment.planning.explain import NoPlan
from rtkit.deployment.planning.model import Model
from rtkit.deployment.planning.model_builder import BuiltModel
from rtkit.deployment.planning.operators import Operator
from rtkit.deployment.planning.rendering import as_plain, lines
from rtkit.deployment.planning.rollback import Rollback
from rtkit.deployment.planning.to_actions import ActionBuilder
from rtkit.deployment.runner import PlanRunner, Talk
from rtkit.deployment.site import Careful, Site, at_once
from rtkit.deployment.system import WantedSystem
from rtkit.errors import Refused, RtkitError, Unreachable, from_kind
from rtkit.fast_dataclass import replace
from rtkit.report.finding import counted

_MOST_PLANS = 10
"""How often it is planned anew before a world that never behaves is given up."""
_MOST_MADE = 2
"""How often one component is made in all these: its code may make another than is wanted."""

See = Callable[[Snapshot], Model]


class Applier:
    """Reaches a goal at one site.

    Attributes:
        unmet: In what required components are not what is wanted, as was seen last.
    """

    def __init__(
        self,
        site: Site,
        goal: DeploymentGoal,
        report: Talk,
        progress: Talk,
        taken: list[tuple[Action, float]] | None = None,
        seen: BuiltModel | None = None,
        careful: Careful = at_once,
        watch: PlanWatch | None = None,
    ) -> None:
        """Prepare to reach `goal`.

        Args:
            site: Where it is reached.
            goal: The goal.
            report: Receives the differences from the plan.
            progress: Receives each step when it is done.
            taken: Gets what the actions took that were done [s].
            seen: Model that the plan was made from, if its notes are reported already.
            careful: Makes the calls; an interruption of the command waits for their end.
            watch: Receives each plan and what becomes of its steps; `progress` nothing then.
        """
        self.unmet = seen.unmet if seen is not None else ()
        self._noted = set(seen.notes if seen is not None else ())
        self._site = site
        self._careful = careful
        self._goal = self._began = goal
        self._report = report
        self._progress = progress
        self._watch = watch
        self._actions = _ActionWatch(watch) if watch is not None else None
        self._runner = PlanRunner(
            site,
            report,
            taken=taken,
            careful=careful,
            is_strict=goal.is_strict,
            watch=self._actions,
        )
        self._look: Callable[[], Snapshot] = lambda: careful(site.snapshot)
        self._moves: Sequence[Operator] = ()
        self._is_exact = False

    def run(
        self,
        plan: DeploymentPlan,
        before: Snapshot,
        *,
        rolls_back: bool = False,
        is_exact: bool = False,
    ) -> None:
        """Carry a plan out that was made from what lived `before`; go back if that fails.

        One that is to be carried out exactly is not planned again where the world differs.

        Raises:
            Refused: A step failed; the message states what is left, or that it went back.
            Unreachable: The manager does not answer.
            KeyboardInterrupt: Interrupted; its text states what is left.
        """
        system = self._goal.system
        self._planned(plan)
        try:
            self._is_exact = is_exact
            self._install(plan)
            plan, before = self._with_managers(plan, before)
            doing = ActionBuilder(system, LiveIndex(before, system))
            self._reach(plan, doing, partial(self._see, before), system)
        except RtkitError as error:
            raise from_kind(error.kind, f"{error}; {self._after(before, rolls_back)}") from error
        except KeyboardInterrupt as error:
            outcome = self._after(before, rolls_back=rolls_back)
            raise KeyboardInterrupt("; ".join(filter(None, (str(error), outcome)))) from error

    def _see(self, before: Snapshot, now: Snapshot) -> Model:
        """Return the model of what lives now; report parts of the wanted system that do not exist.

        Some of it becomes known only when a component lives.
        """
        survey = self._goal.survey(now, before)
        self.unmet = survey.unmet
        for note in survey.notes:
            if note not in self._noted:
                self._noted.add(note)
                self._report(note)
        return survey.model

    def _install(self, plan: DeploymentPlan) -> None:
        """Install the packages of a plan: before anything is touched that lives."""
        for move in plan.moves:
            if move.kind == "install":
                self._do_with_package(move)
                self._finished(move, f"[1/{len(plan.layers)}]")

    def _do_with_package(self, move: Operator) -> None:
        packages = self._goal.packages
        self._do(move, partial(getattr(packages.installer, move.kind), move.subject))
        change = {move.subject}
        known = packages.installed
        there = known | change if move.kind == "install" else known - change
        self._goal = replace(self._goal, packages=replace(packages, installed=there))

    def _do(self, move: Operator, call: Callable[[], object]) -> None:
        """Carry out a step that is no action of a manager."""
        self._note(move, BEGUN)
        try:
            self._careful(call)
        except RtkitError as error:
            self._note(move, FAILED, str(error))
            raise from_kind(error.kind, f"{move.text}: {error}") from error

    def _note(self, move: Operator, state: str, why: str = "") -> None:
        if self._watch is not None:
            self._watch.step(move.text, state, why=why)

    def _planned(self, plan: DeploymentPlan, reason: str = "") -> None:
        if self._watch is not None:
            self._watch.plan(as_plain(plan, self._goal.costs), reason)

    def _finished(self, move: Operator, where: str) -> None:
        if self._actions is not None:
            self._actions.finished(move.text)
        else:
            self._progress(f"{where} {move.text}")

    def _with_managers(
        self, plan: DeploymentPlan, before: Snapshot
    ) -> tuple[DeploymentPlan, Snapshot]:
        """Start the managers of a plan; what they bring back counts as what lived before."""
        starts = [move for move in plan.moves if move.kind == "start_manager"]
        for move in starts:
            self._do(move, partial(self._site.start_manager, move.subject))
            self._finished(move, f"[1/{len(plan.layers)}]")
        if not starts:
            return plan, before
        before = self._look()
        started = {move.subject for move in starts}
        if started.isdisjoint(homes_in(before).values()):
            return plan, before
        why = "a manager came back with what it kept"
        self._differs(why)
        plan = self._goal.plan(before)
        self._planned(plan, why)
        return plan, before

    def _reach(
        self, plan: DeploymentPlan, doing: ActionBuilder, see: See, system: WantedSystem
    ) -> None:
        made: Counter[str] = Counter()
        for _ in range(_MOST_PLANS):
            if not plan.moves:
                return
            made.update(move.subject for move in plan.moves if move.kind.startswith("create"))
            odd = next((name for name, count in made.items() if count > _MOST_MADE), "")
            if odd:
                raise Refused(f"{odd} was made, and is not what the profile says all the same")
            why = self._carry_out(plan, doing, see, system)
            if why:
                self._differs(why)
            plan = make_plan(see(self._look()), self._goal.ranks)
            if plan.moves and self._is_exact:
                self._differs("it led elsewhere")
            if plan.moves:
                self._planned(plan, why or "it led elsewhere")
        raise Refused(f"what lives differed from {_MOST_PLANS} plans")

    def _differs(self, why: str) -> None:
        """Report that the world is not as planned.

        Raises:
            Refused: The plan is to be carried out as it is, or not at all.
        """
        if self._is_exact:
            raise Refused(f"not as planned: {why}; the rest of the saved plan is left")
        self._report(f"not as planned: {why}; planning anew from what is")

    def _carry_out(
        self, plan: DeploymentPlan, doing: ActionBuilder, see: See, system: WantedSystem
    ) -> str:
        """Carry a plan out; return what made it worthless, if anything did."""
        self._moves, count = plan.moves, len(plan.layers)
        for number, layer in enumerate(plan.layers, 1):
            snapshot = self._look()
            model = see(snapshot)
            todo = [plan.moves[n] for n in layer if not _is_done(plan.moves[n], model)]
            for move in (plan.moves[n] for n in layer if plan.moves[n] not in todo):
                if move.kind not in ("install", "start_manager"):  # these are done by now
                    self._note(move, HELD)
            why = next(filter(None, (_obstacle(move, model) for move in todo)), "")
            if why:
                return why
            for move in todo:
                if move.kind in ("install", "uninstall"):
                    self._do_with_package(move)
            rounds = list(
                doing.layers(f"{number} of {count}", todo, model, LiveIndex(snapshot, system))
            )
            awaited = Counter(step.text for each in rounds for step in each.steps)
            todo = self._report_finished(todo, awaited, f"[{number}/{count}]")
            for part in (part for each in rounds for part in self._parts(each)):
                begun = len(self._runner.done)
                try:
                    self._runner.run(LayeredPlan(layers=(part,)))
                finally:
                    # Also of a batch that failed: who reads it wants to know what was done.
                    awaited.subtract(step.text for step in self._runner.done[begun:])
                    todo = self._report_finished(todo, awaited, f"[{number}/{count}]")
        return ""

    def _report_finished(
        self, moves: Iterable[Operator], awaited: Counter[str], where: str
    ) -> list[Operator]:
        """Report the steps of which no action is awaited any more; return the others."""
        left = []
        for move in moves:
            if awaited[move.text] > 0:
                left.append(move)
            else:
                self._finished(move, where)
        return left

    def _parts(self, layer: Layer) -> Iterator[Layer]:
        most = self._goal.parallel or len(layer.steps)
        for first in range(0, len(layer.steps), most):
            yield Layer(layer.name, layer.steps[first : first + most])

    def _after(self, before: Snapshot, rolls_back: bool) -> str:
        """Report what is left after a failure, or go back; never fails itself."""
        try:
            if rolls_back:
                return self._go_back(before)
            rest = self._goal.plan(self._careful(self._site.remains), before)
            for line in lines(rest) if rest.moves else ():
                self._report(line.replace("plan:", "left:", 1))
            return f"{counted(len(rest.moves), 'step')} left; run it again to go on"
        except (RtkitError, KeyboardInterrupt) as trouble:
            return f"what is left is not known ({str(trouble) or 'interrupted again'})"

    def _go_back(self, before: Snapshot) -> str:
        """Lead back to what was; what fails on the way is reported, and the rest goes on."""
        self._is_exact = False

        def survey(now: Snapshot) -> Model:
            goal = self._began if now is before else self._goal
            return goal.survey(now, before, is_back=True).model

        way = Rollback(survey, before)
        self._look = lambda: self._careful(self._site.remains)
        nothing = WantedSystem()
        doing = ActionBuilder(nothing, LiveIndex(before, nothing))
        ended: list[str] | None = None
        is_over = False
        while not is_over:
            try:
                plan = make_plan(way.model(self._look()), self._goal.ranks)
                for line in lines(plan) if plan.moves else ():
                    self._report(line.replace("plan:", "way back:", 1))
                if plan.moves:
                    self._planned(plan, "way back")
                self._runner.failed.clear()
                self._reach(plan, doing, way.model, nothing)
                is_over = True
            except NoPlan as error:
                self._give_up(way, error.variables, error)
            except Refused as error:
                failed = {step.text for step in self._runner.failed}
                moves = [move for move in self._moves if move.text in failed]
                self._give_up(way, (move.changes[0][0] for move in moves), error)
            except Unreachable:
                # A manager that ended takes along what was in it; the others can go back.
                known, ended = ended, way.gone(self._look())
                if ended == known or not ended:
                    raise
        return self._outcome(way, self._look(), self._careful(self._site.end_started))

    def _give_up(self, way: Rollback, variables: Iterable[str], error: RtkitError) -> None:
        given_up = list(variables)
        if not given_up:
            raise error
        way.give_up(given_up)
        self._report(f"way back: {error}; going on with the rest")

    def _outcome(self, way: Rollback, left: Snapshot, started: Sequence[str]) -> str:
        runs_on = (f"manager {name} runs" for name in started)
        unlike = ", ".join([*way.unlike(left), *runs_on])
        but = f", but {unlike}" if unlike else ""
        gone = ", ".join(way.gone(left))
        ended = f", but for what was in manager {gone}, which has ended" if gone else ""
        return f"everything is as it was before{but}{ended}"


class _ActionWatch(PlanWatch):
    """Receives what becomes of actions: a step is done when all of its actions are."""

    def __init__(self, watch: PlanWatch) -> None:
        self._watch = watch
        self._took_s: dict[str, float] = {}

    def step(self, text: str, state: str, took_s: float | None = None, why: str = "") -> None:
        if state == DONE:
            self._took_s[text] = self._took_s.get(text, 0.0) + (took_s or 0.0)
        elif state == FAILED or text not in self._took_s:
            self._watch.step(text, state, why=why)

    def finished(self, text: str) -> None:
        self._watch.step(text, DONE, self._took_s.pop(text, 0.0))


def _is_done(move: Operator, model: Model) -> bool:
    """Return whether the effect of a step holds already, or its subject does not exist."""
    variable, value = move.changes[0]
    if variable.startswith("cfg:") and variable[4:] not in model.keys:
        return True
    now = model.now(variable)
    return now == value or (value.endswith(":slave") and now.startswith(f"{value}/"))


def _obstacle(move: Operator, model: Model) -> str:
    """Return why a step cannot be done as things are; nothing is activated before its time."""
    for need in move.needs:
        if not need.holds(model.now(need.variable)):
            return f"{move.text} needs that {need}"
    for variable in move.heeds if move.kind == "activate" else ():
        is_known = not variable.startswith("cfg:") or variable[4:] in model.keys
        if is_known and not model.allows(variable, model.now(variable)):
            return f"{move.text} comes after {_step_text(model, variable)}"
    return ""


def _step_text(model: Model, variable: str) -> str:
    """Return what is desired of a variable as the step that reaches it."""
    desired = model.desired[variable]
    key = model.keys.get(variable.removeprefix("cfg:"))
    return f"{key.text}{desired}" if key is not None and isinstance(desired, str) else variable
