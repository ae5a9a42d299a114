"""A served class is a component: configured as its constructor, placed by profiles, in trouble."""

from __future__ import annotations

from typing import Any

KEEPS_MANAGER = True

MODULE = '''
from typing import Annotated, Literal

import rtkit
from rtkit import init_of


class Lamp:
    """Shine in a room.

    Args:
        room: Where it is.
        level: How bright it is at first.
    """

    version = "2.1"

    def __init__(
        self,
        room: str,
        level: Annotated[float, rtkit.Range(0, 1), rtkit.Unit("lx")] = 0.5,
        color: Literal["red", "white"] = "white",
        at: tuple[float, ...] = (1.0, 2.0),
        words: tuple[str, ...] = ("a", "b"),
        maximum: float | None = None,
    ):
        self.room, self.level, self.color = room, level, color
        self.at, self.words, self.maximum = at, words, maximum
        self.status = "ready"
        self.is_open = False

    def __enter__(self):
        if self.room == "cellar":
            raise OSError("no lamp there")
        self.is_open = True
        return self

    def __exit__(self, *raised):
        self.is_open = False


LampInit = init_of(Lamp)
'''
LAMP = "/localhost/Lamp0.rtc"


def test_a_component_serves_an_object_of_a_class_while_it_is_active(manager: Any) -> None:
    (manager.modules / "Lamp.py").write_text(MODULE)
    create = "Lamp?conf.default.room=hall&conf.default.words=(x y)&conf.default.maximum=3"
    manager.ok(f"rtmgr /localhost/manager.mgr -c '{create}'")
    shown = manager.ok(f"rtconf -l {LAMP}").splitlines()
    assert [row.split() for row in shown if row.strip().startswith(("at", "color", "room"))] == [
        ["at", "1.0,2.0"],
        ["color", "white"],
        ["room", "hall"],
    ]
    assert "How bright it is at first. [lx]" in manager.ok(f"rtdoc {LAMP}")
    for line in ("level 2", "color blue"):
        assert manager.run(f"rtconf {LAMP} set {line}").status != 0
    assert manager.run("rtget Lamp0.room").status == 1
    manager.ok(f"rtact {LAMP}")
    got = manager.ok("rtget Lamp0.room Lamp0.words Lamp0.at Lamp0.maximum Lamp0.is_open")
    assert got.splitlines() == ['"hall"', '("x" "y")', "(1.0 2.0)", "3.0", "true"]
    manager.ok("""rtset Lamp0.status '"failed: no bulb"'""")
    manager.ok(f"rtwait {LAMP} error")
    assert "failed: no bulb" in manager.ok(f"rtcat {LAMP}")
    assert manager.ok("rtget Lamp0.status") == '"failed: no bulb"\n'
    manager.ok(f"rtreset {LAMP}")
    assert manager.run("rtget Lamp0.status").status == 1


def test_a_system_profile_places_it_and_what_does_not_begin_is_in_error(manager: Any) -> None:
    (manager.modules / "Lamp.py").write_text(MODULE)
    manager.ok("rtmgr /localhost/manager.mgr -c Lamp")
    manager.ok(f"rtconf {LAMP} set service house/lamp")
    manager.ok(f"rtconf {LAMP} set room hall")
    manager.ok("rtcryo --all -o house.xml")
    manager.ok("rtteardown house.xml")
    manager.run("rtapply house.xml")
    assert manager.run("rtstart house.xml").status == 0
    assert manager.ok("rtget house/lamp.room") == '"hall"\n'
    for room, why in (("cellar", "no lamp there"), ("", "parameter room is to be set")):
        manager.run(f"rtreset {LAMP}")
        manager.run(f"rtdeact {LAMP}")
        manager.ok(f"rtconf {LAMP} set room '{room}'")
        assert manager.run(f"rtact {LAMP}").status == 1
        assert why in manager.ok(f"rtcat {LAMP}")
