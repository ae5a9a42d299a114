"""Choices known only at run time, and widgets that a class declares."""

from __future__ import annotations

from typing import Annotated, Any

import pytest

from rtkit import Choices, Gui, Range, Returns, Unit, Word
from rtkit.property.codes import PropertyError
from rtkit.property.reading import read
from tests.unit.property.test_objects import refused, served


class Arm:
    angle: Annotated[float, Gui("knob", width=2)] = 0.0
    gui = Gui(html="<b>arm</b>")


class Player:
    volume: Annotated[float, Gui("knob", html="<p>volume</p>", series=(1, 2))] = 0.5
    speed: Annotated[tuple[float, float], Returns(after=0.25)] = (0.0, 0.0)
    colour: Annotated[str, Choices(("red", "green"))] = "red"
    song: Annotated[str, Choices("songs")] = "one"
    _list: Annotated[str, Choices("songs")] = "one"

    def __init__(self) -> None:
        self.songs = ["one", "two"]
        self.arm = Arm()
        self._seen = 0
        self._level = Word("low")

    def get_level(self) -> Annotated[Word, Choices(lambda player: player._levels())]:
        return self._level

    def set_level(self, level: Word) -> None:
        self._level = level

    def play(
        self,
        song: Annotated[str, Choices("songs")],
        speed: Annotated[float, Unit("1"), Range(0.5, 2, 0.1)] = 1.0,
        mode: Annotated[str, Choices(("loud", "quiet"))] = "loud",
    ) -> str:
        return f"{song} {mode} at {speed}"

    def get_sound(self, channel: Annotated[int, Range(1, 2)] = 1) -> str:
        return f"from {channel}"

    def _levels(self) -> list[Word]:
        return [Word("low"), Word("high")] if len(self.songs) > 1 else []

    def gui(self) -> Gui:
        self._seen += 1
        return Gui(kind="group", html=f"<p>{self._seen}</p>", forms={"svg": "<svg/>"})

    def gui_song(self) -> Gui:
        return Gui(rows=len(self.songs))

    def gui_broken(self) -> int:
        """Do nothing about widgets."""
        return 3


def described(service: Any, name: str) -> dict[str, str]:
    element: Any = read(service.get(name))
    return dict(element.attributes)


def test_choices_are_those_of_the_moment() -> None:
    player = Player()
    service = served(player)
    assert service.get("song.meta.choices") == '("one" "two")'
    assert service.get("level.meta.choices") == "(low high)"
    assert service.get("colour.meta.choices") == '("red" "green")'
    service.set("level", "high")
    assert refused(service, "song", "three") == "bad-value"
    player.songs.append("three")
    service.set("song", "three")
    service.set("properties", "((song two))")
    assert player.song == "two"
    assert refused(service, "properties", "((song nine))") == "bad-value"
    assert refused(service, "colour", "blue") == "bad-value"
    assert described(service, "song.gui")["choices"] == '("one" "two" "three")'
    assert described(service, "song.gui")["kind"] == "choice"
    player.songs = ["one"]
    assert refused(service, "level", "low") == "bad-value"
    player.songs = None  # type: ignore[assignment]
    assert refused(service, "song", "one") == "bad-value"
    assert refused(service, "song.meta") == "internal"
    assert 'name="volume"' in str(service.get("gui"))


def test_widgets_are_declared_beside_a_type() -> None:
    service = served(Player())
    volume = described(service, "volume.gui")
    assert (volume["kind"], volume["series"], volume["forms"]) == ("knob", "(1 2)", "(html)")
    assert service.get("volume.gui.html") == "<p>volume</p>"
    assert described(service, "arm.angle.gui")["width"] == "2"
    speed = described(service, "speed.gui")
    assert (speed["kind"], speed["after"]) == ("joystick", "0.25")
    assert refused(service, "volume.gui.text") == "unknown"
    with pytest.raises(PropertyError, match=r"no such property: gui\.nix$"):
        service.get("gui.nix")
    for name, what in (("volume.gui", "set"), ("gui.listen", "listened to")):
        with pytest.raises(PropertyError, match=rf"^cannot be {what}: .*gui$"):
            service.set(name, "self")


def test_widgets_are_told_by_methods_and_are_no_properties() -> None:
    player = Player()
    service = served(player)
    names = str(service.get("properties"))
    assert "gui)" not in names
    assert "gui_song" not in names
    assert "gui_broken" in names
    assert described(service, "song.gui")["rows"] == "2"
    assert service.get("gui.svg") == "<svg/>"
    assert service.get("gui.html") != service.get("gui.html")
    assert described(service, "gui")["forms"] == "(html svg)"
    assert service.get("arm.gui.html") == "<b>arm</b>"
    tree: Any = read(str(service.get("gui")))
    (arm,) = [each for each in tree.children if each.attributes["name"] == "arm"]
    assert arm.attributes == {"kind": "group", "name": "arm", "forms": "(html)"}
    assert refused(service, "gui.html", "x") == "read-only"


def test_arguments_have_ranges_choices_and_widgets() -> None:
    player = Player()
    service = served(player)
    for wrong in ("(three)", "(one 3)", "(one 1 soft)"):
        assert refused(service, "play", wrong) == "bad-value"
    assert service.get("play.state") == "idle"
    assert "two quiet at 2.0" in str(service.set("play?echo=1", "(two 2 quiet)"))
    assert refused(service, "sound?channel=3") == "bad-parameter"
    assert service.get("sound?channel=2") == '"from 2"'
    tree: Any = read(str(service.get("play.gui")))
    song, speed, mode = (each.attributes for each in tree.children)
    assert (speed["kind"], speed["min"], speed["max"], speed["step"]) == (
        "slider",
        "0.5",
        "2",
        "0.1",
    )
    assert (mode["kind"], mode["choices"]) == ("choice", '("loud" "quiet")')
    assert (song["argument"], speed["default"]) == ("true", "1.0")
    assert '(speed number 1.0 () "")' in str(service.get("play.parameters"))
