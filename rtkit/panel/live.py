"""Live service behind a panel: its widgets, its values as they change, and what is set."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from rtkit.api.asked import Ask
from rtkit.api.client import Client
from rtkit.api.property_change import PropertyChange
from rtkit.closing import Closing
from rtkit.panel.description import Panel, read_panel
from rtkit.panel.dressing import service_of_components, worn
from rtkit.panel.state import WidgetState
from rtkit.property.codes import PropertyError
from rtkit.property.values import Element, Word
from rtkit.property.writing import write

_AT_ONCE = 8
_WATCH_S = 2.0
"""How often a service is asked whether it answers, and how long it may take."""
_LATE = frozenset({"no-service", "timeout"})


class LiveService(Closing):
    """Service, or a part of one, as a panel shows it; listens to all that is shown.

    Args:
        target: ``SERVICE`` or ``SERVICE.PART``, or an address, as `Client` takes it.
        timeout_s: Bound on each request [s].
        components: The GUI service, which has components by type.

    Attributes:
        panel: The widgets.
        shown: What they show, by name.
        name: Of the service.
        is_outdated: Names have come or gone since the widgets were asked for.
        is_partial: Something could not be listened to, or the owner of a mount is away.
        is_silent: The service is there, but does not answer: what is shown may be old.

    Raises:
        PropertyError: It cannot be reached, or there is no such part.
    """

    def __init__(self, target: str, timeout_s: float, components: str = "gui") -> None:
        self.target = target
        self.name = target
        self.is_outdated = self.is_partial = self.is_silent = False
        self.shown: dict[str, WidgetState] = {}
        self._wanted = self._components = components
        self._client = Client(timeout_s)
        self._changes: dict[str, PropertyChange] = {}
        self._lock = threading.Lock()
        self._listened: dict[str, Any] = {}
        self._of_names: dict[str, Any] = {}
        self._wishes: dict[str, Callable[[], object]] = {}
        self._problems: dict[str, str] = {}
        self._is_wished = threading.Event()
        self._ended = threading.Event()
        self._asked: set[str] = set()
        threading.Thread(target=self._fulfil, daemon=True).start()
        try:
            self.refresh()
        except BaseException:
            self.close()
            raise
        threading.Thread(target=self._watch, daemon=True).start()

    def refresh(self) -> None:
        """Ask for the widgets anew, and listen to those that are new.

        Raises:
            PropertyError: The service cannot be reached.
        """
        self.is_outdated = False
        self._components = self._wanted
        panel = read_panel(str(self._client.payload(Ask(f"{self.target}.gui"), 5.0)))
        self.name = self.target[: len(self.target) - len(panel.name)].rstrip("./")
        self.panel = self._dressed(panel)
        drawn = [each for each in self.panel.all() if each.kind != "group"]
        self.shown = {each.name: self.shown.get(each.name) or WidgetState() for each in drawn}
        self.is_partial = any("away" in each.attributes for each in drawn)
        wanted = {each.name: each for each in drawn if not each.is_round}
        groups = [each.name for each in panel.all() if each.kind == "group"]
        for name in set(self._listened) - set(wanted):
            self._listened.pop(name).close()
        new: deque[str] = deque()
        for name, each in wanted.items():
            is_known = name in self._listened or name in self._asked
            if not is_known and each.attributes.get("access") != "w":
                new.append(name)
        self._asked |= set(new)
        for _ in range(min(_AT_ONCE, len(new))):  # a slow one delays no other
            threading.Thread(target=self._listen, args=(new,), daemon=True).start()
        places = [".".join(filter(None, (self.name, each))) for each in groups]
        for place in filter(None, (*places, self._components)):
            names = f"{place}.properties"
            if names not in self._of_names:
                with suppress(PropertyError):
                    self._of_names[names] = self._client.listen(
                        names, self._names_came, initial=0, mode="diff"
                    )

    def _listen(self, names: deque[str]) -> None:
        """Listen to one after the other, beside other threads that do so."""
        while not self._ended.is_set():
            try:
                name = names.popleft()
            except IndexError:  # another thread has taken the last
                return
            target = f"{self.name}.{name}"
            came = partial(self._came, name)
            try:
                self._listened[name] = self._client.listen(target, came, every=0.05)
            except PropertyError as error:
                code = error.code if error.code in _LATE else ""
                self.is_partial |= bool(code)
                self._problems[name] = str(error).removeprefix(f"{target}: ")
                self._came(name, PropertyChange(name, None, 0.0, "bad", code))
            self._asked.discard(name)

    def _watch(self) -> None:
        """Ask for something that is known without work: who is stopped ends no connection."""
        while not self._ended.wait(_WATCH_S):
            try:
                self._client.payload(Ask(f"{self.name}.properties"), _WATCH_S)
                self.is_silent = False
            except PropertyError as error:
                self.is_silent = error.code == "timeout"

    def _came(self, name: str, change: PropertyChange) -> None:
        with self._lock:
            self._changes[name] = change

    def _names_came(self, change: PropertyChange) -> None:
        if not change.code:
            self.is_outdated = True

    def take(self) -> set[str]:
        """Take the changes that have come; return the names of widgets that show something else."""
        with self._lock:
            changes, self._changes = self._changes, {}
            problems, self._problems = self._problems, {}
        for name, change in changes.items():
            if name in self.shown:
                quality = "gone" if change.code else change.quality
                # An owner that returns may have other names than it had.
                self.is_outdated |= self.shown[name].quality == "gone" != quality
                self.shown[name].take(change.value, quality)
        for name, problem in problems.items():
            if name in self.shown:
                self.shown[name].problem = problem
        return (changes.keys() | problems.keys()) & self.shown.keys()

    def wish(self, name: str, work: Callable[[], object]) -> None:
        """Have something done for a widget, soon; of what waits for one, only the latest is."""
        with self._lock:
            self._wishes[name] = work
        self._is_wished.set()

    def _fulfil(self) -> None:
        while not self._ended.is_set():
            self._is_wished.wait()
            self._is_wished.clear()
            with self._lock:
                wishes, self._wishes = self._wishes, {}
            for name, work in wishes.items():
                self._problems[name] = self._tried(name, work)

    def _tried(self, name: str, work: Callable[[], object]) -> str:
        """Return why something cannot be done, empty if it was; then what is so is shown again."""
        try:
            work()
            return ""
        except PropertyError as error:
            with suppress(PropertyError):
                value = self._client.get(f"{self.name}.{name}")
                self._came(name, PropertyChange(name, value, 0.0))
            return str(error).removeprefix(f"{self.name}.{name}: ")

    def set(self, name: str, value: Any) -> None:
        """Set a property: to a value, or to the text of one, as its type is.

        Raises:
            PropertyError: It is refused; its code tells why.
        """
        panel = next((each for each in self.panel.all() if each.name == name), None)
        is_string = panel is not None and panel.attributes.get("type") == "string"
        if is_string and isinstance(value, str):
            value = write(str(value))
        self._client.set(f"{self.name}.{name}", str(value) if isinstance(value, Word) else value)

    def call(self, panel: Panel, arguments: dict[str, str]) -> None:
        """Start an action, with the texts of those arguments that were given.

        Raises:
            PropertyError: It is refused; its code tells why.
        """
        target = f"{self.name}.{panel.name}"
        texts = {each.name: _text(each, arguments.get(each.name, "")) for each in panel.arguments}
        given = {key: text for key, text in texts.items() if text}
        only = "".join(texts.values()) if len(texts) == 1 else ""
        if only and not only.startswith("("):
            self._client.set(target, only)
        else:
            self._client.set(target, "", **given)

    def stop(self, name: str) -> None:
        """Stop an action.

        Raises:
            PropertyError: It cannot be stopped.
        """
        self._client.set(f"{self.name}.{name}.stop", True)

    # Components that services bring along, as <gui> elements

    def _dressed(self, panel: Panel) -> Panel:
        """Return widgets with the components of properties, or of their types, put on."""
        group = service_of_components(panel)
        if group:
            self._components = f"{self.name}.{group}"

        def of_type(word: str) -> Panel | None:
            if not self._components:
                return None
            return self._component(f"{self._components}.{word}.text", is_followed=True)

        return worn(panel, self.name, self._component, of_type)

    def _component(self, target: str, *, is_followed: bool = False) -> Panel | None:
        """Return a component, None if there is none, or it is no ``<gui>``."""
        try:
            value = self._client.get(target)
            if is_followed and target not in self._of_names:
                self._of_names[target] = self._client.listen(target, self._names_came, initial=0)
            return read_panel(value if isinstance(value, str) else write(value))
        except PropertyError as error:
            if error.code == "no-service" and is_followed:
                self._components = ""
            return None

    def close(self) -> None:
        """Listen no longer."""
        self._ended.set()
        self._is_wished.set()
        self._client.close()


def _text(panel: Panel, text: str) -> str:
    """Return the text of an argument as a value: of a string, and of a place as a marker."""
    if not text:
        return ""
    if panel.attributes.get("type") in ("string", "text"):
        return write(text)
    if panel.kind == "marker" and not text.startswith("<"):
        return write(Element("marker", {}, (Element("location", {}, (), _numbers(text)),)))
    return text


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(each) for each in text.strip("() ").split())
    except ValueError:
        raise PropertyError("bad-value", f"expected numbers: {text[:40]}") from None
