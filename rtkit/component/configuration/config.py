"""Configuration sets: named sets of text parameters, of which one is active.

Writing a set changes text only, and text that a parameter cannot have is refused. What a
component sees changes when a set was activated and its execution context comes to the next state
update, never in the middle of a cycle.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Mapping
from typing import Any, cast

from rtkit.component.configuration.constraint_check import misfits, parameter_names
from rtkit.component.configuration.kinds import ParameterKind, Value, kind_of
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.names import check_set_name

DEFAULT = "default"


def is_hidden(set_id: str) -> bool:
    """Return whether listings omit a set: two underscores before and after its name."""
    return len(set_id) > 4 and set_id.startswith("__") and set_id.endswith("__")


def nobody(change: str, name: str) -> None:
    """Ignore a change."""


class Configuration:
    """The configuration sets of one component and the parameters bound to them.

    `set`, `activate`, `add_set` and `remove_set` may be called by one thread while another,
    which drives the component, calls `update`: sets are replaced, never changed in place.

    Attributes:
        values: Values that the component sees, by parameter name.
        report: Called with one line when text could not be converted.
        changed: Called with the kind of change (``set_updated``, ``set_added``, ``set_removed``,
            ``set_activated``, ``parameter_updated``) and the name of what changed.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        self._sets: dict[str, dict[str, str]] = {DEFAULT: {}}
        self._added: set[str] = set()
        self._kinds: dict[str, tuple[ParameterKind, Value]] = {}
        self._pending: deque[tuple[str, dict[str, str]]] = deque(maxlen=1)
        self._active_set = DEFAULT
        self.values: dict[str, Any] = {}
        self.report = report
        self.changed: Callable[[str, str], None] = nobody

    @property
    def sets(self) -> Mapping[str, Mapping[str, str]]:
        """Every set with its text parameters, hidden ones too."""
        return dict(self._sets)

    @property
    def active_set(self) -> str:
        """The set whose values the component sees."""
        return self._active_set

    @property
    def is_pending(self) -> bool:
        """Return whether an activation waits for the next state update."""
        return bool(self._pending)

    def bind(self, name: str, default: Value, kind: ParameterKind | None = None) -> None:
        """Declare a parameter: its kind is that of its default value, if no other is given."""
        kind = kind or kind_of(default)
        self._kinds[name] = (kind, default)
        self.values[name] = default
        present = self._sets[DEFAULT]
        text = present.get(name, kind.write(default))
        others = {each: present[each] for each in present if each != name}
        self._sets[DEFAULT] = {**others, name: text}  # in the order of declaration

    def declare(self, set_id: str, values: Mapping[str, str]) -> None:
        """Give initial text to a set, which then is one of those that cannot be removed."""
        if not set_id:
            raise Malformed("a configuration set needs a name")
        self._sets[set_id] = {**self._sets.get(set_id, {}), **values}

    def adopt(self, sets: Mapping[str, Mapping[str, str]], active_set: str) -> None:
        """Take exactly these sets, as they stand in a description that is not checked here."""
        self._sets = {set_id: dict(values) for set_id, values in sets.items()}
        self._active_set = active_set

    def set(self, set_id: str, values: Mapping[str, str]) -> None:
        """Change the text of some parameters of one set, all or none.

        Raises:
            NotFound: No such set, or no such parameter in it.
            Malformed: A text that a parameter cannot have; names parameter, text and constraint.
        """
        present = self._find(set_id)
        self._check(set_id, values, present)
        self._sets[set_id] = {**present, **values}
        for name in values:
            self.changed("parameter_updated", f"{set_id}.{name}")
        self.changed("set_updated", set_id)

    def _check(self, set_id: str, values: Mapping[str, str], known: Collection[str]) -> None:
        """Refuse values of parameters that there are not, or that these cannot have."""
        for name in values:
            if name not in known:
                raise NotFound(f"No such configuration parameter: {name}")
        why = self.misfits(set_id, values)
        if why:
            raise Malformed(why)

    def add_set(self, set_id: str, values: Mapping[str, str]) -> None:
        """Add a set at run time.

        Raises:
            Refused: One of that name exists.
            NotFound: No set has a parameter of such a name.
            Malformed: No set may have that name, or a parameter cannot have a text.
        """
        if set_id in self._sets:
            raise Refused(f"configuration set {set_id} exists already")
        check_set_name(set_id)
        self._check(set_id, values, parameter_names(self._sets))
        self._sets[set_id] = dict(values)
        self._added.add(set_id)
        self.changed("set_added", set_id)

    def remove_set(self, set_id: str) -> None:
        """Remove a set that was added at run time.

        Raises:
            NotFound: No such set.
            Refused: It came with the component, or it is the active one.
        """
        self._find(set_id)
        if set_id not in self._added:
            raise Refused(f"configuration set {set_id} was not added at run time")
        if set_id in (self._active_set, *(waiting for waiting, _ in self._pending)):
            raise Refused(f"configuration set {set_id} is the active one")
        del self._sets[set_id]
        self._added.discard(set_id)
        self.changed("set_removed", set_id)

    def activate(self, set_id: str) -> None:
        """Ask for a set to become the active one at the next state update.

        Raises:
            NotFound: No such set.
            Refused: The name is empty or begins with an underscore, or the set holds a text that
                a parameter cannot have.
        """
        if not set_id or set_id.startswith("_"):
            raise Refused(f"configuration set {set_id or repr('')} cannot be activated")
        texts = self._find(set_id)
        why = self.misfits(set_id, texts)
        if why:
            raise Refused(f"configuration set {set_id} cannot be activated: {why}")
        self._pending.append((set_id, texts))

    def update(self) -> bool:
        """Take over a pending activation; return whether there was one.

        Called by whatever drives the component, between two cycles.
        """
        try:
            set_id, texts = self._pending.pop()
        except IndexError:
            return False
        self.apply(set_id, texts)
        self.changed("set_activated", set_id)
        return True

    def apply(self, set_id: str, texts: Mapping[str, str]) -> None:
        """Make the component see these texts; a parameter that they do not name keeps its value."""
        values = dict(self.values)
        for name, text in texts.items():
            if name in self._kinds:
                values[name] = self._convert(set_id, name, text)
        self.values = values
        self._active_set = set_id

    def _convert(self, set_id: str, name: str, text: str) -> Value:
        kind, default = self._kinds[name]
        try:
            return cast(Value, kind.read(text))
        except Malformed as error:
            self.report(
                f"configuration parameter {set_id}.{name}: {error}; the default"
                f" {kind.write(default)} is used"
            )
            return default

    def misfits(self, set_id: str, values: Mapping[str, str]) -> str:
        """Return the texts that the parameters cannot have, with reasons; empty when all fit.

        A hidden set holds hints, not values. A default that breaks its own constraint is accepted.
        """
        if is_hidden(set_id):
            return ""
        given = {
            name: text
            for name, text in values.items()
            if name not in self._kinds or text != self._written_default(name)
        }
        return misfits(self._sets, given.items()) if given else ""

    def _written_default(self, name: str) -> str:
        kind, default = self._kinds[name]
        return kind.write(default)

    def _find(self, set_id: str) -> dict[str, str]:
        found = self._sets.get(set_id)
        if found is None:
            raise NotFound(f"No such configuration set: {set_id}")
        return found
