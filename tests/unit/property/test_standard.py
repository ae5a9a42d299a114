"""Properties that every service has, whether its class declares them or not."""

from __future__ import annotations

from typing import Final

from rtkit.property.messages import Answer
from rtkit.property.objects import Exported
from rtkit.property.requests import PropertyRequest
from rtkit.property.service import Service
from rtkit.property.standard import add_standard
from tests.unit.property.test_objects import refused
from tests.unit.property.test_subscription import Ear


class Lamp:
    on = False


class Rover:
    type: Final = ("mobilerobot", "two wheels")
    version: Final = "1.2"
    __version__ = "0.3"

    def __init__(self) -> None:
        self.moves = False

    @property
    def status(self) -> str:
        return "moving" if self.moves else "ready"


def served(thing: object) -> Service:
    service = Service("o")
    add_standard(service.values, "o", thing)
    Exported(service, thing)
    return service


FOUR = "properties?names=(name type status version)&values=1"


def test_every_service_has_name_type_status_and_version() -> None:
    service = served(Lamp())
    assert service.get(FOUR) == '((name "o") (type (lamp)) (status "ready") (version "unknown"))'
    assert service.get("properties") == "(on)"
    assert service.get("type.0") == "lamp"
    assert service.get("status.meta.access") == "r"
    assert refused(service, "status", "done") == "read-only"
    for unknown in ("nothing", "status.x", "typ", "type.7"):
        assert refused(service, unknown) == "unknown"


def test_members_of_the_class_win() -> None:
    rover = Rover()
    service = served(rover)
    assert service.get("type") == '(mobilerobot "two wheels")'
    assert service.get("type.meta.type") == '"list<word>"'
    assert service.get("version") == '"1.2"'
    rover.moves = True
    assert service.get("status") == '"moving"'
    lamp = Lamp()
    service = served(lamp)
    lamp.status = "broken"  # type: ignore[attr-defined]
    assert service.get("status") == '"broken"'


def test_a_status_can_be_listened_to_until_it_is_not() -> None:
    service = served(Lamp())
    ear, answers = Ear(), list[Answer]()
    service.handle(PropertyRequest("status.listen", "self", answers.append, ear))
    (listener,) = ear.listeners
    event = listener.take(0.0)
    assert event is not None
    assert event.payload == '"ready"'
    service.handle(PropertyRequest("status.listen?remove=1", "self", answers.append, ear))
    assert ear.listeners == []
    assert service.values.standard.nodes["status"].listeners is None
    assert [each.error for each in answers] == ["", ""]
