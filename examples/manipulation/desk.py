"""The operator's desk: the dialogue as live properties, questions as properties with choices."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rtkit
from manipulation import drawing
from manipulation.dialogue import Dialogue
from manipulation.language import text_of
from rtkit.errors import Malformed, NotFound, RtkitError
from rtkit.property.codes import PropertyError
from rtkit.property.naming import segment_of
from rtkit.property.property_spec import PropertySpec
from rtkit.property.service import Service
from rtkit.property.types import Content, parse_type
from rtkit.property.values import Value, Word
from rtkit.wires.serve import ServedObject

_PICTURES = ("site", "explored", "way", "tree")
Shown = dict[str, tuple[PropertySpec, Content, Any]]


class Desk:
    """Serves a dialogue; whoever touches the dialogue holds the lock.

    Args:
        dialogue: What is served.
        name: Of the service.
        lock: Of the dialogue.
        heard: Called, with the lock held, after each thing that the operator said.
    """

    def __init__(
        self,
        dialogue: Dialogue,
        name: str,
        lock: threading.Lock,
        heard: Callable[[], object],
    ) -> None:
        self._dialogue, self._lock, self._heard = dialogue, lock, heard
        self._service = Service()
        self._shown: Shown = {}
        self._publishing = threading.Lock()
        for each in _PICTURES:
            spec = PropertySpec(parse_type("text"), "r", doc=f"SVG: {drawing.TITLES[each]}")
            self._service.add(f"picture.{each}", spec=spec, read=self._drawn(each))
        self._served: ServedObject | None = None
        self.publish()
        self._served = rtkit.serve(self._service, name)

    def close(self) -> None:
        """Serve it no longer."""
        if self._served is not None:
            self._served.close()

    def publish(self) -> None:
        """Have the properties be what the dialogue is now."""
        with self._publishing:
            with self._lock:
                now = shown(self._dialogue)
            before = self._shown
            if now == before:
                return
            apply = lambda: self._apply(before, now)  # noqa: E731
            apply() if self._served is None else self._served.owned(apply)
            self._shown = now

    def _apply(self, before: Shown, now: Shown) -> None:
        for name, (spec, _, _) in before.items():
            if name not in now or now[name][0] != spec:
                self._remove(name)
        for name, (spec, value, act) in now.items():
            known = before.get(name)
            if known is None or known[0] != spec or name not in self._service.registry.nodes:
                write = self._does(act) if act is not None else None
                is_choice = bool(spec.choices)  # it has no value: an answer ends it
                first = None if is_choice else value
                read = (lambda _given: Word("open")) if is_choice else None
                self._service.add(name, first, spec, read=read, write=write)
            elif known[1] != value:
                self._service.update(name, value)

    def _remove(self, name: str) -> None:
        if name in self._service.registry.nodes:
            self._service.remove(name)

    def _does(self, act: tuple[str, ...]) -> Callable[[Content, dict[str, Value]], None]:
        """Return what takes a value that the operator sets."""

        def write(value: Content, _given: dict[str, Value]) -> None:
            try:
                with self._lock:
                    method = getattr(self._dialogue, act[0])
                    method(*act[1:], value if isinstance(value, float | int) else str(value))
                    self._heard()
            except NotFound as error:
                raise PropertyError("bad-value", str(error)) from error
            except Malformed as error:
                raise PropertyError("bad-value", str(error)) from error
            except RtkitError as error:
                raise PropertyError("conflict", str(error)) from error
            self.publish()

        return write

    def _drawn(self, which: str) -> Callable[[dict[str, Value]], str]:
        def read(_given: dict[str, Value]) -> str:
            with self._lock:
                return drawing.picture(self._dialogue, which)

        return read


def shown(dialogue: Dialogue) -> Shown:
    """Return all properties: what is declared, the value, and what a SET calls, if it may."""
    site = dialogue.site
    found: Shown = {}

    def show(name: str, kind: str, value: Content, doc: str, act: Any = None, **more: Any) -> None:
        spec = PropertySpec(parse_type(kind), "rw" if act else "r", doc=doc, **more)
        found[name] = (spec, value, act)

    show("command", "text", dialogue.heard, "a sentence for the supervisor", ("hear",))
    show("said", "text", dialogue.said, "what it said last")
    show("state", "word", Word(dialogue.state), "idle, asking, working or stopped")
    _show_questions(dialogue, show)
    shown_alternatives = tuple(
        (Word(a.letter), a.way.cost, *((Word(n), c) for n, c in a.way.costs.items()), str(a.way))
        for a in dialogue.shown
    )
    show(
        "alternatives", "list", shown_alternatives, "letter, cost, cost by criterion, what is done"
    )
    show("alternatives.ties", "list", tuple(map(Word, dialogue.shown_ties)), "equally cheap ones")
    steps = dialogue.running.steps if dialogue.running else []
    lines = tuple(f"{s.kind} {text_of(s.pose[:2])} {s.name}".strip() for s in steps)
    show("plan", "list", lines, "steps that are left, the one that is being done first")
    show("plan.cost", "number", sum(s.price + s.risk for s in steps), "of the steps that are left")
    show("plan.jobs", "list", tuple(job.text for job in dialogue.jobs), "tasks that are not done")
    show("hand", "list", (*site.hand[:2], site.hand[2]), "place and quarter turns of the jaws")
    show("holding", "text", site.holding, "what is in the jaws")
    things = tuple((n, (t.pose[0], t.pose[1]), _known(t)) for n, t in site.things.items())
    show("site", "text", drawing.as_text(site), "the table, a character for each place")
    show("site.things", "list", things, "name, place, how far from its middle it was felt [places]")
    unknown = tuple(n for n, t in site.things.items() if not t.is_named)
    show("site.unknown", "list", unknown, "things found by touch that have no name yet")
    show("site.walls", "list", tuple(sorted(site.walls)), "places of walls")
    places = tuple((n, place) for n, place in site.places.items())
    show("site.places", "list", places, "named places")
    show("site.regions", "list", tuple((n, *each) for n, each in site.regions.items()), "regions")
    for name, price in site.prices._asdict().items():
        about = {"move": "a step of the empty hand", "carry": "a step with a load"}
        doc = f"price of {about.get(name, 'a quarter turn')}"
        show(f"prices.{name}", "number", price, doc, ("set_price", name), minimum=0.0)
    for name in site.regions:
        segment, doc = segment_of(name), f"what entering a place of {name} costs more"
        value = site.risks.get(name, 0.0)
        show(f"risks.{segment}", "number", value, doc, ("set_price", name), minimum=0.0)
    for name, (parameters, body) in dialogue.definitions.items():
        text = f"{' '.join(parameters)} = {body}".strip()
        show(f"definitions.{segment_of(name)}", "text", text, f"what {name} does")
    show("evaluations", "integer", dialogue.legs.evaluations, "searches in a cross-section, ever")
    show("remembered", "integer", dialogue.legs.remembered, "answers from memory instead")
    show("results", "list", tuple(dialogue.results), "task, outcome, cost, evaluations it took")
    return found


def _known(thing: Any) -> Value:
    return tuple(round(each, 3) for each in thing.found) if thing.found is not None else Word("?")


def _show_questions(dialogue: Dialogue, show: Callable[..., None]) -> None:
    asked = tuple(
        (Word(id), q.text, tuple(map(_word, q.choices))) for id, q in dialogue.asked.items()
    )
    show("questions.open", "list", asked, "id, text, choices")
    for id, question in dialogue.asked.items():
        choices = tuple(map(_word, question.choices))
        act = ("answer", id)
        kind = "any" if choices else "text"
        show(f"questions.{id}", kind, "", question.text, act, choices=choices)
        details = question.details
        show(
            f"questions.{id}.details",
            "text",
            "".join(f"{each}\n" for each in details),
            "what the choices mean",
        )


def _word(text: str) -> Value:
    return Word(text) if text.replace("-", "").replace("_", "").isalnum() else text
