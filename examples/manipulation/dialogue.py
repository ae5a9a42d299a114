"""The dialogue with the operator: a state machine that hears sentences, asks, plans and acts.

It touches no clock, file, port or thread. Sentences, answers, prices and reports of the manipulator
go in; orders for it, questions and what there is to see come out. Questions may be answered in any
order, late, or never; each belongs to a task or a thing, and is withdrawn with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from manipulation.execution import CELL, QUARTER, Execution
from manipulation.jobs import Asked, Job
from manipulation.knowledge import Site, Thing
from manipulation.language import (
    Cancel,
    Define,
    Designate,
    Forget,
    Place,
    Sentence,
    Take,
    Task,
    body_of,
    called_by,
    endless,
    parse,
    text_of,
)
from manipulation.legs import Legs, Search
from manipulation.orders import Order, Report
from manipulation.ways import (
    Alternative,
    Blocked,
    Part,
    PlanStep,
    Way,
    Ways,
    alternatives,
    goals_of,
    view_of,
)
from rtkit.errors import LimitReached, Malformed, NotFound, Refused, RtkitError

_OFF = 0.01
"""How far from the middle of a place the hand counts as being off it [places]."""
NONE = "none"
"""The choice that drops what was asked for."""


@dataclass
class Dialogue:
    """What is known, what is to be done, what is being asked.

    Attributes:
        definitions: Parameters and body of each defined command.
        jobs: Tasks that are not done, in the order in which they were given.
        asked: Open questions by id.
        offered: Alternatives by question.
        results: Text, outcome, cost and evaluations of tasks that ended.
        said: What was last told the operator.
        heard: What the operator said last that was understood.
        revision: Grows with everything that is to survive.
    """

    site: Site
    definitions: dict[str, tuple[tuple[str, ...], str]] = field(default_factory=dict)
    jobs: list[Job] = field(default_factory=list)
    asked: dict[str, Asked] = field(default_factory=dict)
    offered: dict[str, list[Alternative]] = field(default_factory=dict)
    ties: dict[str, list[str]] = field(default_factory=dict)
    results: list[tuple[str, str, float, int]] = field(default_factory=list)
    said: str = ""
    heard: str = ""
    revision: int = 0
    numbers: dict[str, int] = field(default_factory=lambda: {"job": 0, "question": 0, "thing": 0})

    def __post_init__(self) -> None:
        self.legs = Legs(self.site.width, self.site.height)
        self.running: Execution | None = None
        self._parts: list[Part] = []
        self.last: Report | None = None
        self.shown: list[Alternative] = []
        self.shown_ties: list[str] = []
        self.searches: list[Search] = []
        self.way = Way(())
        self.view = view_of(self.site)
        self._at_work: Job | None = None
        self._is_off = False
        self._is_changed = False

    # what the operator says

    def hear(self, text: str) -> None:
        """Do what a sentence says.

        Raises:
            Malformed: It cannot be understood.
            NotFound: Nothing has a name in it.
            Refused: It cannot be done; the message states why.
        """
        parameters = {name: each[0] for name, each in self.definitions.items()}
        sentence: Sentence = parse(text, parameters)
        if isinstance(sentence, Designate):
            self._designate(sentence)
        elif isinstance(sentence, Forget):
            self._forget(sentence.name)
        elif isinstance(sentence, Define):
            self._define(sentence)
        elif isinstance(sentence, Cancel):
            self._cancel()
        else:
            self._begin(" ".join(text.split()), sentence)
        self.heard = text
        self.revision += 1

    def answer(self, id: str, text: str) -> None:
        """Take the answer to a question.

        Raises:
            NotFound: It is not open (any more).
            Malformed: It is no answer to it.
        """
        question = self.asked.get(id)
        if question is None:
            raise NotFound(f"no such question is open: {id}")
        if question.choices and text not in question.choices:
            raise Malformed(f"{id}: one of {' '.join(question.choices)}")
        if question.kind == "name":
            self._named(question, text)
        else:
            self._decided(question, text)
        self.revision += 1
        self._go_on()

    def set_price(self, name: str, value: float) -> None:
        """Set a price (`move`, `carry`, `turn`), or the risk of a region; plans follow at once.

        Raises:
            Malformed: It is not greater than 0 (a risk: not below 0).
            NotFound: There is no such price or region.
        """
        self.site.set_price(name, value)
        self.said = f"{name} costs {value:g}"
        self._reconsider()
        self.revision += 1

    def resume(self, jobs: list[Job]) -> None:
        """Go on with tasks that were given before a restart; what was open is asked again."""
        self.jobs = jobs
        for name, thing in self.site.things.items():
            if not thing.is_named:
                self._ask_name(name, thing.pose[:2])
        self._reconsider()

    def _designate(self, said: Designate) -> None:
        site, first = self.site, said.places[0]
        if said.kind == "wall":
            site.add_walls(said.places)
        elif said.kind == "region" and said.name:
            site.add_region(said.name, said.places)
        elif said.kind == "place" and said.name:
            site.add_place(said.name, first)
        elif said.kind in ("region", "place"):
            raise Malformed(f"designate {said.kind} at (x y) NAME: the name is missing")
        else:
            shape = tuple((x - first[0], y - first[1]) for x, y in said.places)
            thing = Thing((*first, 0), shape, is_bar=said.kind == "bar", is_named=bool(said.name))
            name = said.name or self._unknown_name()
            site.add(name, thing)
            if not said.name:
                self._ask_name(name, first)
        self.said = f"{said.kind} {said.name or ''} at {' '.join(map(text_of, said.places))}"
        self._reconsider()

    def _forget(self, name: str) -> None:
        if name in self.definitions:
            known = self.definitions
            users = [each for each in known if name in called_by(known, each)]
            if users:
                raise Refused(f"{name} is used by {' and '.join(users)}")
            del self.definitions[name]
        else:
            if any(name in job.names for job in self.jobs):
                raise Refused(f"{name} is part of a task: cancel it first")
            self.site.forget(name)
            self._waited_for(name)
        self.said = f"forgot {name}"
        self._reconsider()

    def _define(self, said: Define) -> None:
        definitions = {**self.definitions, said.name: (said.parameters, said.body)}
        parameters = {name: each[0] for name, each in definitions.items()}
        body_of(said.body, said.parameters, said.parameters, parameters, said.name)
        if cycle := endless(definitions, said.name):
            raise Refused(f"{said.name} cannot end: {' calls '.join(cycle)}")
        self.definitions = definitions
        self.said = f"defined {' '.join([said.name, *said.parameters])}"

    def _cancel(self) -> None:
        for job in self.jobs:
            self.results.append((job.text, "cancelled", job.spent, job.evaluations))
        self.jobs.clear()
        self.asked = {id: each for id, each in self.asked.items() if each.kind == "name"}
        self.offered.clear()
        self.said = "cancelled"

    def _begin(self, text: str, task: Task) -> None:
        goals = goals_of(task, self.site, self.definitions)
        self.numbers["job"] += 1
        job = Job(self.numbers["job"], text, goals)
        self.jobs.append(job)
        self._consider(job)
        self._go_on()

    # what is asked

    def _ask(
        self,
        kind: str,
        text: str,
        choices: Sequence[str],
        about: int | str,
        details: Sequence[str] = (),
    ) -> str:
        """Ask; a question about the same is replaced and keeps its id."""
        id = next((id for id, each in self.asked.items() if each.about == about), "")
        if not id:
            self.numbers["question"] += 1
            id = f"q{self.numbers['question']}"
        self.asked[id] = Asked(id, kind, text, tuple(choices), about, tuple(details))
        self.said = f"{id}: {text}"
        return id

    def _withdraw(self, about: int | str) -> None:
        for id in [id for id, each in self.asked.items() if each.about == about]:
            del self.asked[id]
            self.offered.pop(id, None)
            self.ties.pop(id, None)

    def _waited_for(self, thing: str) -> None:
        """Go on where a task was stopped by a thing."""
        self._withdraw(thing)
        for job in self.jobs:
            job.waits_for = "" if job.waits_for == thing else job.waits_for

    def _unknown_name(self) -> str:
        self.numbers["thing"] += 1
        return f"unknown{self.numbers['thing']}"

    def _ask_name(self, name: str, place: Place) -> None:
        self._ask("name", f"what is at {text_of(place)}? its name", (), name)

    def _named(self, question: Asked, text: str) -> None:
        name = " ".join(text.split())
        self.site.rename(str(question.about), name)
        self._waited_for(str(question.about))
        self.said = f"{text_of(self.site.things[name].pose[:2])} is {name}"
        self._reconsider()

    def _decided(self, question: Asked, text: str) -> None:
        job = self._job(question.about)
        if text == NONE:
            self._end(job, "dropped")
        elif question.kind == "choice":
            chosen = next(each for each in self.offered[question.id] if each.letter == text)
            self._withdraw(job.number)
            self._settle(job, chosen.way)
            self.said = str(chosen)
        elif question.kind == "lost":
            self._withdraw(job.number)
            for thing in self.site.things.values():
                thing.empty.clear()
            self._consider(job)
        else:
            self._withdraw(job.number)
            job.goals = [
                goal._replace(into=text) if isinstance(goal, Take) else goal for goal in job.goals
            ]
            self._consider(job)

    def _job(self, number: int | str) -> Job:
        return next(job for job in self.jobs if job.number == number)

    # what is planned

    def _consider(self, job: Job) -> None:
        """Plan a task: it is ready, or a question is asked, or it ends as impossible."""
        before = self.legs.evaluations
        self.legs.searches = []
        try:
            offered, tied = alternatives(self.site, self.legs, job.left)
        except Blocked as blocked:
            text = f"{blocked}; into which region may it go?"
            job.is_ready = False
            self._ask("clear", text, (*self.site.regions, NONE), job.number)
            return
        except (Refused, LimitReached) as error:
            self._end(job, f"impossible: {error}")
            return
        finally:
            job.evaluations += self.legs.evaluations - before
            self.searches = self.legs.searches or self.searches
        self.shown, self.shown_ties = offered, tied
        self.way, self.view = offered[0].way, view_of(self.site)
        if len(offered) == 1:
            self._withdraw(job.number)
            self._settle(job, offered[0].way)
            self.said = str(offered[0])
            return
        job.is_ready = False
        ties = f"; {' and '.join(tied)} tie at {offered[0].way.cost:g}" if tied else ""
        text = f"{len(offered)} ways to {job.text}{ties}: which?"
        letters = [each.letter for each in offered]
        id = self._ask("choice", text, (*letters, NONE), job.number, [str(e) for e in offered])
        self.offered[id], self.ties[id] = offered, tied

    def _settle(self, job: Job, way: Way) -> None:
        """Have a task done in this way, which begins where it stands now."""
        of = job.chosen[job.done][1] if job.done < len(job.chosen) else 0
        job.chosen = [*job.chosen[: job.done], *((p.goal, of + p.of) for p in way.parts)]
        job.is_ready = True
        self.way, self.view = way, view_of(self.site)

    def _reconsider(self) -> None:
        """Plan anew what something has changed for: names, places, prices."""
        self._is_changed = True
        for job in [job for job in self.jobs if not job.is_ready]:
            if all(each.about != job.number or each.kind != "lost" for each in self.asked.values()):
                self._consider(job)
        self._go_on()

    def _end(self, job: Job, outcome: str) -> None:
        self._withdraw(job.number)
        self.jobs.remove(job)
        self.results.append((job.text, outcome, job.spent, job.evaluations))
        self.said = f"{job.text}: {outcome}"
        if outcome == "done":
            self.said += f", cost {job.spent:g}"

    # what is done

    @property
    def current(self) -> Job | None:
        """Return the task that is at work, or would be next."""
        return next((job for job in self.jobs if job.is_ready), None)

    @property
    def is_stopped(self) -> bool:
        """Return whether a thing that was found by touch waits for its name."""
        return any(job.waits_for for job in self.jobs)

    @property
    def order(self) -> Order | None:
        """Return what the manipulator is to do now."""
        return self.running.order if self.running is not None else None

    def see(self, report: Report) -> None:
        """Take a report of the manipulator, and go on."""
        if self.last is None:
            if report.outcome == "busy":
                return  # it does what was ordered before a restart: look when it stands
            self._find_oneself(report)
        elif report.number < self.last.number:
            self.running = None  # the manipulator has begun anew
            self._is_changed = True
            self._find_oneself(report)
        self.last = report
        if self.running is None:
            self._go_on()
            return
        step = self.running.steps[0] if self.running.steps else None
        if self.running.see(report) and step is not None:
            self._stepped(step.price + step.risk)
            self._go_on(is_between=True)
        elif self.running.order is None:
            self._surprised(self.running)
            self._go_on()

    def _find_oneself(self, report: Report) -> None:
        """Compare what was known before a restart with what is seen."""
        site = self.site
        place = (round(report.x / CELL), round(report.y / CELL))
        before, site.hand = site.hand, (*place, round(report.theta / QUARTER) % 2)
        off = max(abs(report.x / CELL - place[0]), abs(report.y / CELL - place[1]))
        self._is_off = off > _OFF
        if not report.is_gripping:
            site.holding = ""
        elif not site.holding:
            below = [name for name, each in site.things.items() if each.pose[:2] == place]
            site.holding = below[0] if below else self._unknown_name()
            site.things.setdefault(site.holding, Thing(site.hand, is_named=False))
        if site.holding:
            thing = site.things[site.holding]
            thing.pose = (*place, site.hand[2] if thing.is_bar else thing.pose[2])
        if self.current is not None and self.last is None:
            self.current.spent += site.price_between(before, site.hand)
        if report.outcome == "touched":
            met = (report.contact_x / CELL, report.contact_y / CELL)
            self._found((round(met[0]), round(met[1])), self.current)

    def _found(self, place: Place, job: Job | None) -> None:
        """Make a thing known that was touched, and ask what it is."""
        poses = {name: each.pose for name, each in self.site.things.items()}
        if place in self.site.blocked(poses) or not self.site.is_inside(place):
            return
        name = self._unknown_name()
        self.site.add(name, Thing((*place, 0), is_named=False))
        self._ask_name(name, place)
        if job is not None:
            job.waits_for = name
        self.said = f"stopped: something is at {text_of(place)}; its name?"

    def _stepped(self, price: float) -> None:
        self.revision += 1
        job, running = self._at_work, self.running
        if job is None or running is None or job not in self.jobs:
            return
        job.spent += price
        left = len(running.steps)
        while self._parts and sum(len(part.steps) for part in self._parts[1:]) >= left:
            self._parts.pop(0)
            job.done += 1
        if not self._parts:
            self._end(job, "done")

    def _surprised(self, running: Execution) -> None:
        self.running = None
        self.revision += 1
        job = self._at_work
        if running.event == "touched" and running.unknown is not None:
            self._found(running.unknown, job if job in self.jobs else None)
        elif job is None or job not in self.jobs:
            return
        elif running.event == "lost":
            job.is_ready = False
            name = running.steps[0].name
            place = text_of(self.site.things[name].pose[:2])
            self._ask("lost", f"{name} is not near {place}", ("again", NONE), job.number)
        else:
            self._end(job, "impossible: the manipulator cannot go on")

    def _go_on(self, *, is_between: bool = False) -> None:
        """Begin what is next; between two steps also plan anew what something has changed for."""
        if self.last is None or (self.running is not None and not is_between):
            return  # what was ordered is done first
        job = self.current
        if job is None or self.is_stopped:
            self.running = None
        elif self.running is None or self._is_changed or job is not self._at_work:
            self._plan(job)

    def _plan(self, job: Job) -> None:
        """Plan what is left of a task from where everything is now."""
        self._is_changed = False
        self.running = None
        goals = [goal for goal, _ in job.chosen[job.done :]]
        before = self.legs.evaluations
        self.legs.searches = []
        try:
            self.way = Ways(self.site, self.legs).all(goals, view_of(self.site))[0]
            self.view = view_of(self.site)
        except RtkitError:
            self._consider(job)  # what was chosen cannot be done any more
            if not job.is_ready or job not in self.jobs:
                return
        finally:
            job.evaluations += self.legs.evaluations - before
            self.searches = self.legs.searches or self.searches
        self._begin_way(job, self.way)

    def _begin_way(self, job: Job, way: Way) -> None:
        self._at_work = job
        self._parts = list(way.parts)
        while self._parts and not self._parts[0].steps:
            self._parts.pop(0)
            job.done += 1
        if not self._parts:
            self._end(job, "done")
            self._go_on()
            return
        steps = list(way.steps)
        if self._is_off:
            steps.insert(0, PlanStep("over", self.site.hand))
            self._is_off = False
        assert self.last is not None
        self.running = Execution(self.site, steps, self.last.number)

    @property
    def state(self) -> str:
        """Return a word for what goes on."""
        if self.is_stopped:
            return "stopped"
        if self.current is not None:
            return "working"
        return "asking" if self.asked else "idle"
