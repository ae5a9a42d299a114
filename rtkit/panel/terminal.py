"""Draws a panel in a terminal with textual, by keyboard and mouse."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable, Iterator
from functools import partial
from time import monotonic
from typing import Any, ClassVar

from rich.text import Text
from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding
from textual.containers import Vertical, VerticalScroll
from textual.screen import ModalScreen
from textual.timer import Timer
from textual.widget import Widget
from textual.widgets import Footer, Input, Static

from rtkit.panel import drawing, state
from rtkit.panel.description import Panel
from rtkit.panel.live import LiveService
from rtkit.panel.served import ServedPanel
from rtkit.property.conversion import to_value
from rtkit.property.values import is_number, is_vector
from rtkit.property.writing import write

_NAME_COLUMNS = 18
_SETTLED_S = 0.3
"""How long values of earlier wishes may still come back."""
_LOOK_S = 3.0
"""How often it is looked for what is away."""
_HELD_S = 0.7
"""How long a joystick stays where an arrow key has moved it: terminals tell of no release."""
_STYLES = {"accent": "bold cyan", "alarm": "bold red", "warn": "bold yellow", "dim": "dim", "": ""}
_ACTED = frozenset({"slider", "toggle", "choice", "button"})
_EDITED = frozenset(
    {"text", "number", "slider", "knob", "vector", "marker", "table", "tree", "map", "label"}
)


class PanelRow(Widget, can_focus=True):
    """One widget of a panel: its name, what it shows, its unit and its state."""

    DEFAULT_CSS = """
    PanelRow { height: auto; padding: 0 1; }
    PanelRow:focus { background: $boost; border-left: thick $accent; padding: 0 1 0 0; }
    """

    def __init__(self, panel: Panel, app: PanelApp) -> None:
        super().__init__()
        self.panel = panel
        self.shown = app.live.shown[panel.name]
        self.part = 0
        self.tooltip = Text(panel.attributes["doc"]) if "doc" in panel.attributes else None
        self.can_focus = not panel.is_read_only
        self._panel_app = app
        self._timer: Timer | None = None
        self._held_until = self._wished_until = 0.0
        self._wished: Any = None

    def render(self) -> Text:
        """Draw it."""
        panel, shown = self.panel, self.shown
        name = panel.attributes.get("label", panel.name.rpartition(".")[2])
        found = "stale" if self._live.is_silent else shown.state(panel)
        made = Text()
        for index, line in enumerate(drawing.lines(panel, shown, self._width, self.part)):
            made.append("\n" if index else "")
            for text, style in line:
                faded = " dim" if found in ("gone", "stale") else ""
                made.append(text, (_STYLES.get(style, style) + faded).strip())
            if not index:
                made.append(f" {panel.attributes.get('unit', '')}".rstrip(), "dim")
                if found:
                    style = _STYLES[drawing.STYLES.get(found, "warn")]
                    made.append(f"  {drawing.SIGNS[found]}", style)
        if panel.kind == "button":
            made.append("  Enter starts, s stops" if self.has_focus else "", "dim")
        if shown.problem:
            made.append(f"\n{drawing.text_of(shown.problem)}", _STYLES["alarm"])
        head = f"{name[: _NAME_COLUMNS - 1]:{_NAME_COLUMNS}}"
        rows = made.wrap(self.app.console, max(20, self._columns))
        return Text(head) + Text("\n" + " " * _NAME_COLUMNS).join(rows)

    @property
    def _width(self) -> int:
        return max(20, self._columns - 16)

    @property
    def _columns(self) -> int:
        return (self.size.width or self._panel_app.size.width) - _NAME_COLUMNS

    def on_resize(self) -> None:
        """Take as many lines as it needs in its new width."""
        self.refresh(layout=True)

    async def press(self, key: str) -> bool:
        """Change the value, or a part of it, or have it typed; return whether the key does that."""
        value, panel = self.shown.value, self.panel
        if monotonic() < self._wished_until and is_number(self._wished):
            value = self._wished  # that of an earlier wish may just have come back
        wanted = state.wish(panel, value, key, self.part)
        if wanted is not None:
            self.wish(wanted)
        elif panel.kind == "joystick" and is_vector(value) and (moved := self._steered(key)):
            self._hold(moved)
        elif panel.kind == "vector" and key in ("left", "right") and is_vector(value):
            self.part = (self.part + (1 if key == "right" else -1)) % max(1, len(value))
            self.refresh()
        elif panel.kind == "button" and key in ("enter", "space"):
            await self._start()
        elif panel.kind == "button" and key == "s":
            self._panel_app.ask(panel.name, None, partial(self._live.stop, panel.name))
        elif key == "enter" and panel.kind in _EDITED:
            await self._edit()
        else:
            return False
        return True

    async def on_click(self, event: events.Click) -> None:
        """Do what a key would; a slider goes where it is clicked, a choice is the one clicked."""
        panel = self.panel
        if panel.kind not in _ACTED or panel.is_read_only:
            return
        column = event.x - 1 - _NAME_COLUMNS
        if panel.kind == "slider":
            low, high = panel.number("min", 0.0), panel.number("max", 1.0)
            part = min(1.0, max(0.0, column / drawing.slider_room(self._width)))
            self.wish(float(f"{low + part * (high - low):.4g}"))
        elif panel.kind == "button":
            await self._start()
        else:
            at = (
                drawing.choice_at(panel, column) if panel.kind == "choice" and column >= 0 else None
            )
            key = "space" if panel.kind == "toggle" else "right"
            self.wish(state.wish(panel, self.shown.value, key) if at is None else at)

    @property
    def _live(self) -> LiveService:
        return self._panel_app.live

    def wish(self, value: Any) -> None:
        """Show what is wished, and have it set."""
        self._wished, self._wished_until = value, monotonic() + _SETTLED_S
        self.shown.take(value, self.shown.quality)
        self._panel_app.ask(self.panel.name, value, partial(self._live.set, self.panel.name, value))
        self._panel_app.show(self)

    async def _edit(self) -> None:
        as_text = drawing.text_of if self.panel.kind in ("text", "label") else _text

        def done(given: dict[str, str] | None) -> None:
            if given is not None:
                set = partial(self._live.set, self.panel.name, given[self.panel.name])
                self._panel_app.ask(self.panel.name, given[self.panel.name], set)

        text = as_text(self.shown.value)
        if "\n" in text:  # a field has one line
            self.shown.problem = "several lines: rtset with --file sets them"
            self._panel_app.show(self)
            return
        await self.app.push_screen(Form(self.panel.name, [(self.panel, text)]), done)

    async def _start(self) -> None:
        def call(given: dict[str, str] | None) -> None:
            if given is not None:
                work = partial(self._live.call, self.panel, given)
                self._panel_app.ask(self.panel.name, tuple(given.values()), work)

        arguments = [(each, each.attributes.get("default", "")) for each in self.panel.arguments]
        if arguments:
            await self.app.push_screen(Form(self.panel.name, arguments, "starts"), call)
        else:
            call({})

    # Joystick: held as long as keys come, zero after that, and wherever the user goes elsewhere

    def _steered(self, key: str) -> tuple[float, ...] | None:
        value = self.shown.value
        return state.steered(self.panel, drawing.axes(self.panel, value), len(value), key)

    def _hold(self, moved: tuple[float, ...]) -> None:
        if not any(moved):
            self.release()
            return
        self._held_until = monotonic() + _HELD_S
        self.wish(moved)
        if self._timer is None:
            again_s = self.panel.number("after", 0.5) / 4
            self._timer = self.set_interval(again_s, self._repeat)

    def _repeat(self) -> None:
        if monotonic() > self._held_until:
            self.release()
        else:
            self.wish(self.shown.value)

    def release(self) -> None:
        """Let a joystick go back to zero, if it is held."""
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
            self.wish((0.0,) * len(self.shown.value))

    def on_focus(self) -> None:
        """Say where the user is."""
        self._panel_app.focused_on(self.panel.name)

    def on_blur(self) -> None:
        """Hold nothing that the user has left."""
        self.release()


def _text(value: Any) -> str:
    if value is None or isinstance(value, bytes):
        return ""
    found = to_value(value)
    return "" if isinstance(found, bytes) else write(found)


class Form(ModalScreen[dict[str, str] | None]):
    """Asks for texts: of a value, or of the arguments of an action."""

    DEFAULT_CSS = """
    Form { align: center middle; }
    Form > Vertical {
        width: 70; max-width: 95%; height: auto; border: round $accent; padding: 0 1;
        background: $surface;
    }
    """
    BINDINGS: ClassVar = [("escape", "dismiss(None)", "Cancel")]

    def __init__(self, name: str, asked: list[tuple[Panel, str]], verb: str = "sets") -> None:
        super().__init__()
        self._title = f"{name}: Enter {verb}, Escape cancels"
        self._asked = asked

    def compose(self) -> ComposeResult:
        """Make the fields."""
        with Vertical():
            yield Static(Text(self._title, "bold"))
            for panel, text in self._asked:
                keys = "name", "unit", "choices", "doc"
                words = [panel.attributes[each] for each in keys if panel.attributes.get(each)]
                yield Static(Text("  ".join(words)))
                yield Input(text, placeholder=panel.attributes.get("type", ""))

    def on_mount(self) -> None:
        """Have what is typed from now on go into the first field."""
        if self.focused is None:
            self.set_focus(self.query(Input).first())

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Go to the next field; after the last, return what was given."""
        inputs = list(self.query(Input))
        if event.input is not inputs[-1]:
            self.focus_next()
            return
        names = [panel.name for panel, _ in self._asked]
        self.dismiss({name: each.value for name, each in zip(names, inputs, strict=True)})


class _Box(VerticalScroll, can_focus=False, inherit_bindings=False):
    """All widgets; scrolls to where the user is: arrow keys are the app's."""


class PanelApp(App[None]):
    """Panel of a service.

    Args:
        live: The service.
        name: Under which the panel is served, empty if it is not.
    """

    CSS = """
    #state { dock: top; padding: 0 1; background: $panel; }
    .group { padding: 1 1 0 1; text-style: bold; }
    .below { height: auto; margin-left: 2; border-left: solid $panel; }
    """
    BINDINGS: ClassVar = [
        ("q", "quit", "Quit"),
        Binding("down,j,tab", "go(1)", "Next", key_display="↓", priority=True),
        Binding("up,k,shift+tab", "go(-1)", "Previous", key_display="↑", priority=True),
        Binding("ctrl+down", "scroll(1)", "Scroll", key_display="^↓", priority=True),
        Binding("ctrl+up", "scroll(-1)", show=False, priority=True),
        ("ctrl+r", "again", "Ask again"),
    ]
    ENABLE_COMMAND_PALETTE = False
    AUTO_FOCUS = ""

    def __init__(self, live: LiveService, name: str = "") -> None:
        super().__init__()
        self.live = live
        self._rows: dict[str, PanelRow] = {}
        self._is_asking = self._was_silent = False
        self._state = Static(id="state", markup=False)
        self._box = _Box(id="panel")
        self._served = ServedPanel(name, live.set) if name else None

    async def on_event(self, event: events.Event) -> None:
        """Take keys one after the other: a key goes where those before it have led."""
        if isinstance(event, events.Key) and not event.is_forwarded:
            row = self.focused
            if isinstance(row, PanelRow) and await row.press(event.key):
                return
        await super().on_event(event)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool:
        """Leave keys that lead from widget to widget to a form while it is open."""
        return action != "go" or not isinstance(self.screen, Form)

    def action_go(self, by: int) -> None:
        """Go to the next widget, or to the one before; where there is none, scroll."""
        went = self.screen.focus_next() if by > 0 else self.screen.focus_previous()
        if went is None:
            self.action_scroll(by)

    def action_scroll(self, by: int) -> None:
        """Scroll by some lines: also to what only shows something."""
        self._box.scroll_relative(y=3 * by, animate=False, immediate=True)

    def compose(self) -> ComposeResult:
        """Make the widgets."""
        yield self._state
        with self._box:
            yield from self._widgets(self.live.panel)
        yield Footer()

    def _widgets(self, panel: Panel) -> Iterator[Widget]:
        if panel.kind != "group":
            field = self._rows[panel.name] = PanelRow(panel, self)
            yield field
        elif panel.name:
            yield Static(Text(panel.attributes.get("label", panel.name)), classes="group")
        below = [widget for each in panel.children for widget in self._widgets(each)]
        if below:
            yield from [Vertical(*below, classes="below")] if panel.name else below

    def on_mount(self) -> None:
        """Begin to follow the service."""
        self.title = self.live.name
        for ending in (
            signal.SIGHUP,
            signal.SIGTERM,
        ):  # the terminal is closed, or somebody ends it
            asyncio.get_running_loop().add_signal_handler(ending, self.exit)
        self.set_interval(0.05, self._follow)
        self.set_interval(_LOOK_S, self._look)
        self._follow()
        first = next((each for each in self._rows.values() if each.can_focus), None)
        self.screen.set_focus(first, scroll_visible=False)  # what stands above it is seen

    def _follow(self) -> None:
        if not self._state.is_attached:
            return  # the panel ends
        for name in self.live.take():
            field = self._rows.get(name)
            if field is not None:
                self.show(field)
        lost = [each for each in self._rows.values() if each.shown.quality == "gone"]
        is_lost = bool(lost) and len(lost) == len(self._rows)
        is_silent = self.live.is_silent
        if is_silent != self._was_silent:
            self._was_silent = is_silent
            for field in self._rows.values():
                field.refresh(layout=True)
        why = "◷ no answer" if is_silent else "⊘ not there" if is_lost else ""
        words = f"{why}: what is shown is what was known last" if why else "● live"
        name = f"  as {self._served.name}" if self._served is not None else ""
        style = "red" if why else ""
        words = f"  {words}{name}"
        self._state.update(Text.assemble((self.live.target, "bold"), words, style=style))
        if self.live.is_outdated and not self._is_asking:
            self.action_again()

    def _look(self) -> None:
        if self.live.is_partial and not self._is_asking:
            self.action_again()

    def action_again(self) -> None:
        """Ask for the widgets anew, and draw them if they are others."""
        self._is_asking = True
        self.run_worker(self._asked_again, thread=True, exit_on_error=False)

    def _asked_again(self) -> None:
        from rtkit.errors import RtkitError

        before = self.live.panel
        try:
            self.live.refresh()
        except RtkitError:
            self.live.is_outdated = True
        finally:
            self._is_asking = False
        if self.live.panel != before:
            self.call_from_thread(self._draw_again)

    async def _draw_again(self) -> Any:
        where = self.focused.panel.name if isinstance(self.focused, PanelRow) else ""
        await self._box.remove_children()
        self._rows.clear()
        widgets = list(self._widgets(self.live.panel))
        if self._served is not None:
            self._served.keep({name: field.panel for name, field in self._rows.items()})
        for field in self._rows.values():
            self.show(field)
        await self._box.mount_all(widgets)
        if where in self._rows:
            self._rows[where].focus()

    def show(self, field: PanelRow) -> None:
        """Serve what a widget shows, then draw it: what is on the screen can be asked for."""
        if self._served is not None:
            self._served.show(field.panel, field.shown.value)
        field.refresh(layout=True)

    def ask(self, name: str, value: Any, work: Callable[[], object]) -> None:
        """Have something done that the user has asked for."""
        self.live.wish(name, work)
        if self._served is not None:
            self._served.input(name, value)

    def focused_on(self, name: str) -> None:
        """Take where the user is."""
        if self._served is not None:
            self._served.focus(name)

    def on_unmount(self) -> None:
        """Let go of what is held."""
        for each in self._rows.values():
            each.release()
        if self._served is not None:
            self._served.close()
