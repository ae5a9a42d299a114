"""Old components beside the native ones they were converted to, under the same inputs.

Both run in this process without manager: the old one by the adapter. Their callbacks are called in
the same order, and what leaves their out ports is recorded.
"""

from __future__ import annotations

import io
import os
import random
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

from rtkit.component import Component, InPort, OutPort, Time
from rtkit.component.contexts.callbacks import attempt
from rtkit.component.values.type_layout import (
    ArrayLayout,
    EnumLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
)
from rtkit.modules.loader import Loader
from rtkit.openrtm.convert.conversion import Conversion
from rtkit.rtc.create import CreateString
from rtkit.rtc.profiles import ConnectorProfile

CYCLES = 12
_WORDS = ("", "a", "True", "0", "3", "日本", "one two", "data/x", "名詞")
_KEPT = ("conf", "ini", "txt", "csv", "yaml", "xml")
Record = list[tuple[str, Any]]
"""What a component did: values by out port, and failures by callback."""


def value_of(layout: Layout, chance: random.Random) -> Any:
    """Return any value of a layout; small numbers, which components take for indices."""
    if isinstance(layout, StructLayout):
        if layout.cls is Time:
            return Time(chance.randrange(100), chance.randrange(10**9))
        return layout.cls(*(value_of(item, chance) for _, item in layout.fields))
    if isinstance(layout, ItemsLayout):
        return tuple(value_of(layout.item, chance) for _ in range(chance.randrange(3, 6)))
    if isinstance(layout, ArrayLayout):
        return tuple(value_of(item, chance) for item in layout.items)
    if isinstance(layout, EnumLayout):
        return chance.choice([*layout.numbers])
    if layout.cls is bool:
        return chance.random() < 0.5
    if layout.cls is int:
        return chance.randrange(4)
    if layout.cls is float:
        return chance.randrange(-40, 80) / 8.0
    if layout.cls is bytes:
        return bytes(chance.randrange(128) for _ in range(4))
    return chance.choice("abc") if layout.name in ("char", "wchar") else chance.choice(_WORDS)


def without_times(value: Any) -> Any:
    """Return a value as plain tuples, without its time stamps."""
    if is_dataclass(value):
        found = [getattr(value, each.name) for each in fields(value)]
        return tuple(without_times(each) for each in found if not isinstance(each, Time))
    return tuple(map(without_times, value)) if isinstance(value, (list, tuple)) else value


def folder_beside(source: Path, folder: Path) -> Path:
    """Return a folder with links to what lies beside a source, but not to the source itself."""
    folder.mkdir()
    for each in source.parent.iterdir():
        if each.name != source.name and not each.name.startswith((".", "__pycache__")):
            (folder / each.name).symlink_to(each)
    return folder


def original(source: Path, folder: Path, text: bytes) -> type[Component]:
    """Return the component class by which the adapter runs an old component."""
    file = folder_beside(source, folder) / source.name
    file.write_bytes(text)
    return _loaded(file, "")


def native(source: Path, folder: Path, conversion: Conversion) -> type[Component]:
    """Return the component class of a converted module."""
    file = folder_beside(source, folder) / source.name
    file.write_text(conversion.text, encoding="utf-8")
    inits = [
        line.split("(")[0].removeprefix("def ")
        for line in conversion.text.splitlines()
        if line.startswith("def ") and "Init(manager: Manager)" in line
    ]
    return _loaded(file, inits[0])


def _loaded(file: Path, init: str) -> type[Component]:
    loader = Loader([])
    with within(file.parent):
        profile = loader.load(str(file), init)
        made = loader.make(CreateString(profile.types[0].type_name))
    return type(made)


@contextmanager
def within(folder: Path) -> Iterator[None]:
    """Have old habits do no harm: the working directory, waiting, asking somebody."""
    before, path = os.getcwd(), [*sys.path]
    os.chdir(folder)
    answers = io.StringIO("".join(f"{n % 4}\n" for n in range(500)))
    try:
        with (
            patch.object(sys, "stdin", answers),
            patch.object(time, "sleep", lambda _s: None),
            redirect_stdout(io.StringIO()),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # of texts with odd escapes
            yield
    finally:
        os.chdir(before)
        sys.path[:] = path


def record(cls: type[Component], folder: Path, seed: int = 1) -> Record:
    """Return what a component does with inputs that depend on the seed only."""
    found: Record = []
    chance = random.Random(seed)
    random.seed(seed)
    with within(folder):
        component = cls("Tried0")
        found.append(("on_initialize", _kind(attempt(component.on_initialize))))
        sinks = _connect(component, found)
        for name in ("on_startup", "on_activated"):
            found.append((name, _kind(attempt(getattr(component, name), "0"))))
        for cycle in range(CYCLES):
            _feed(component, sinks, chance)
            if cycle == CYCLES // 2:
                _configure(component, chance)
            found.append(("on_execute", _kind(attempt(component.on_execute, "0"))))
        for name in ("on_deactivated", "on_shutdown"):
            found.append((name, _kind(attempt(getattr(component, name), "0"))))
    return found


def _kind(failure: Any) -> str:
    """Return what kind of failure it was; both ends name other lines."""
    if failure.error is None:
        return str(failure).partition(" (")[0]
    return type(failure.error).__name__


def _connect(component: Component, found: Record) -> dict[str, Any]:
    sinks = {}
    for name in sorted(component.ports):
        port = component.ports[name]
        if isinstance(port, InPort):
            sinks[name] = port.open(ConnectorProfile(name, name, (), {}))
        elif isinstance(port, OutPort):
            port.attach(name, _recorder(found, name))
    return sinks


def _recorder(found: Record, name: str) -> Callable[[Any], None]:
    return lambda value: found.append((name, without_times(value)))


def _feed(component: Component, sinks: dict[str, Any], chance: random.Random) -> None:
    for name, sink in sinks.items():
        port = component.ports[name]
        assert isinstance(port, InPort)
        for _ in range(chance.choice((0, 1, 1, 1, 2))):
            sink(value_of(layout_of(port.data_type), chance))


def _configure(component: Component, chance: random.Random) -> None:
    """Change each parameter that is a number, as a set from outside would."""
    configuration = component.configuration
    active = configuration.active_set
    for name, text in sorted(configuration.sets[active].items()):
        if text.lstrip("-").isdigit():
            configuration.set(active, {name: str(chance.randrange(1, 4))})
        elif text.replace(".", "", 1).isdigit():
            configuration.set(active, {name: str(chance.randrange(1, 9) / 4.0)})
    configuration.update()
