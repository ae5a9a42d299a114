"""Reference interpreter of state machines: replays a log, written apart from the one under test.

It knows neither do actions nor expressions beyond ``NAME OP NUMBER`` joined by ``and``, ``or`` and
``not``, and works with sets of active states where the other walks paths.
"""

from __future__ import annotations

import operator
import re
from typing import Any

_SIGNS = {
    "<=": operator.le,
    ">=": operator.ge,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "=": operator.eq,
}


class Reference:
    """Replays the inputs of a log; `outputs` is what a right machine must have logged."""

    def __init__(self, machine: Any) -> None:
        self.machine = machine
        self.active: set[str] = set()
        self.variables: dict[str, Any] = {}
        self.values: dict[str, Any] = {}
        self.raised: list[str] = []
        self.outputs: list[tuple[str, str]] = []
        self.mode = "stopped"
        self.clock = self.last = 0.0
        self.entered: dict[str, float] = {}
        self.over: list[tuple[str, Any]] = []

    @property
    def leaf(self) -> str:
        return max(self.active, key=len, default="")

    def replay(self, log: Any, read: Any = lambda detail: detail) -> None:
        """Replay; `read` makes a machine of the detail of an edit."""
        for index, entry in enumerate(log):
            kind, text = entry.kind, entry.text
            is_input = kind in ("run", "value", "event", "time", "edited")
            if not is_input and not (kind == "assign" and entry.detail is not None):
                continue
            if (kind, text) == ("run", "done"):
                continue
            if self.mode == "running":
                self.clock += entry.time - self.last
            self.last = entry.time
            if self.mode == "stepping" and kind not in ("value", "event"):
                self.mode = "paused"
            if kind == "edited":
                later = (e.text for e in log[index:] if e.text.endswith(": edited"))
                goto = next(later, " -> ").split(" -> ")[1].partition(":")[0]
                self.edit(read(entry.detail), goto)
                continue
            if kind in ("value", "event") and self.mode == "running":
                self.settle()
            if kind == "value":
                self.take_value(text.split()[0], entry.detail)
            else:
                getattr(self, f"_{kind}")(text, entry.detail, read)

    def settle(self, event: str = "") -> None:
        budget = 1 if self.mode == "stepping" else 1000
        if event:
            budget -= self.fire(event)
        while budget and self.mode in ("running", "stepping"):
            if self.fire(""):
                budget -= 1
            elif self.raised:
                budget -= self.fire(self.raised.pop(0))
            else:
                break
        if self.mode == "stepping" and not budget:
            self.mode = "paused"
        wanted = self.wanted()
        self.values = {k: v for k, v in self.values.items() if k in wanted}

    def wanted(self) -> set[str]:
        found: set[str] = set()
        for path in self.active:
            for way in self.machine.states[path].transitions:
                found |= set(re.findall(r"[a-z]+\.[a-z]+", way.when.text if way.when else ""))
        return {each for each in found if not each.startswith("variables.")}

    def _run(self, word: str, *_: Any) -> None:
        if word == "start" and self.mode != "paused":
            self.variables = dict(self.machine.variables)
            self.values, self.mode, self.raised = {}, "running", []
            self.enter(self.machine.initial, set())
        elif word == "start":
            self.mode = "running"
        elif word == "pause":
            self.mode = "paused"
        elif word == "step":
            self.mode = "stepping"
        elif word == "stop":
            self.leave(set())
            self.mode, self.raised = "stopped", []
        self.settle()

    def take_value(self, name: str, value: Any) -> None:
        if name in self.wanted():
            self.values[name] = value
        self.settle()

    def _event(self, text: str, *_: Any) -> None:
        self.settle(text)

    def _time(self, *_: Any) -> None:
        self.settle()

    def _assign(self, text: str, value: Any, *_: Any) -> None:
        self.outputs.append(("assign", text))
        self.variables[text.split()[0]] = value
        self.settle()

    def edit(self, new: Any, goto: str) -> None:
        leaf = self.leaf
        kept = {e for e in self.active if leaf.startswith(f"{e}.") and goto.startswith(f"{e}.")}
        is_gone = bool(leaf) and leaf not in new.states
        was_final = bool(leaf) and self.machine.states[leaf].is_final
        if is_gone:
            self.leave(kept)
        before = {k: v for k, v in self.variables.items() if k in new.variables}
        self.variables = {**new.variables, **before}
        self.machine = new
        if is_gone:
            self.outputs.append(("transition", f"{leaf} -> {goto}: edited"))
            self.enter(goto, kept)
        elif leaf and new.states[leaf].initial:
            self.enter(new.states[leaf].initial, set(self.active))
        elif leaf and new.states[leaf].is_final and not was_final:
            self.end(leaf)
        self.settle()

    # One transition.

    def fire(self, event: str) -> bool:
        if self.mode == "done":
            return False
        for path in sorted(self.active, key=len, reverse=True):
            for way in self.machine.states[path].transitions:
                if self.is_enabled(path, way, event):
                    self.take(path, way)
                    return True
        return False

    def is_enabled(self, path: str, way: Any, event: str) -> bool:
        if bool(way.on) != bool(event):
            return False
        if way.on and way.on != "*" and (event + ".").find(way.on + ".") != 0:
            return False
        if way.after is not None and self.clock - self.entered[path] < way.after:
            return False
        if (path, way) in self.over and not way.to + way.on:
            return False
        return way.when is None or self.holds(way.when.text) is True

    def holds(self, text: str) -> bool | None:
        for word, decides in ((" or ", True), (" and ", False)):
            if word in text:
                found = [self.holds(each) for each in text.split(word)]
                return decides if decides in found else None if None in found else not decides
        if text.startswith("not "):
            inside = self.holds(text[4:])
            return None if inside is None else not inside
        name, sign, number = text.split()
        own = name.startswith("variables.")
        value = self.variables[name[10:]] if own else self.values.get(name)
        return None if value is None else _SIGNS[sign](value, float(number))

    def take(self, path: str, way: Any) -> None:
        to = way.to or self.leaf
        parts = [f"on {way.on}"] * bool(way.on)
        parts += [f"when {way.when.text}"] if way.when else []
        parts += [f"after {way.after:g}"] if way.after is not None else []
        self.outputs.append(("transition", f"{self.leaf} -> {to}: {' '.join(parts) or 'at once'}"))
        if way.after is not None:
            self.over.append((path, way))
        if not way.to:
            return self.act(way.actions)
        kept = {
            each
            for each in self.active
            if path.startswith(f"{each}.") and to.startswith(f"{each}.")
        }
        self.leave(kept)
        self.act(way.actions)
        return self.enter(to, kept)

    def leave(self, kept: set[str]) -> None:
        for each in sorted(self.active - kept, key=len, reverse=True):
            self.act(self.machine.states[each].exit)
            self.active.discard(each)
            self.over = [pair for pair in self.over if pair[0] != each]

    def enter(self, to: str, kept: set[str]) -> None:
        while self.machine.states[to].initial:
            to = self.machine.states[to].initial
        names = to.split(".")
        for count in range(1, len(names) + 1):
            path = ".".join(names[:count])
            if path not in kept:
                self.active.add(path)
                self.entered[path] = self.clock
                self.act(self.machine.states[path].entry)
        if self.machine.states[to].is_final:
            self.end(to)

    def end(self, path: str) -> None:
        if "." in path:
            self.raised.append("done." + path.rpartition(".")[0])
        else:
            self.mode = "done"

    def act(self, actions: Any) -> None:
        for each in actions:
            if each.kind == "raise":
                self.raised.append(each.target)
            elif each.kind == "set":
                self.outputs.append(("set", f"{each.target} {each.value}"))
            else:
                if each.expression:
                    name, sign, number = each.expression.text.split()
                    before = self.variables[name[10:]]
                    value = before + int(number) if sign == "+" else before - int(number)
                else:
                    value = int(each.value)
                self.variables[each.target] = value
                self.outputs.append(("assign", f"{each.target} {value}"))
