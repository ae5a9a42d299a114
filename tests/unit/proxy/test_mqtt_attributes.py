"""Addresses of brokers, and what Homie is told of a property."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed, RtkitError
from rtkit.property.naming import canonical
from rtkit.property.reading import read
from rtkit.property.values import Element
from rtkit.wires.mqtt.address import MqttAddress, read_address
from rtkit.wires.mqtt.feed import attributes_of
from rtkit.wires.mqtt.session import name_of, topic_of


def test_addresses() -> None:
    assert read_address("me@localhost/lab") == MqttAddress("me", "localhost", 1883, "lab")
    at = read_address("me@127.0.0.1:99/lab/left")
    assert (at.port, at.path, str(at)) == (99, "lab/left", "mqtt:me@127.0.0.1:99/lab/left")
    for wrong in ("localhost/lab", "@localhost/lab", "me@/lab", "me@localhost", "me@localhost/",
                  "me@localhost:x/lab", "me@localhost:70000/lab", "me@localhost/a//b",
                  "me@localhost/#", "me@localhost/a+"):  # fmt: skip
        with pytest.raises(Malformed, match="not mqtt:USER@HOST"):
            read_address(wrong)
    with pytest.raises(RtkitError, match="on this host only"):
        read_address("me@192.0.2.1/lab")


@pytest.mark.parametrize("name", ["speed", "arm.joint.1", "a%20b", "a+b", "a%2Fb", "set.get"])
def test_names_survive_as_topics(name: str) -> None:
    topic = topic_of(name)
    assert not set("+#") & set(topic)
    assert canonical(name_of(topic)) == name


@pytest.mark.parametrize(
    ("meta", "told"),
    [
        ("<type>number</type><access>rw</access><unit>m</unit><min>-1</min><max>2.5</max>",
         {"$datatype": "float", "$settable": "true", "$unit": "m", "$format": "-1:2.5"}),
        ("<type>word</type><access>r</access><choices>(idle drive)</choices>",
         {"$datatype": "enum", "$settable": "false", "$format": "idle,drive"}),
        ("<type>boolean</type><access>w</access>", {"$datatype": "boolean", "$settable": "true"}),
        ("<type>vector[6]</type><access>r</access><min>0</min>",
         {"$datatype": "string", "$settable": "false"}),
    ],
)  # fmt: skip
def test_attributes(meta: str, told: dict[str, str]) -> None:
    element = read(f"<meta>{meta}</meta>")
    assert isinstance(element, Element)
    assert attributes_of("x", element) == {"$name": "x", **told}
