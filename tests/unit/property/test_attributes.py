"""Attributes of elements as parts of a value."""

from __future__ import annotations

import pytest

from rtkit.property.codes import PropertyError
from rtkit.property.service import Service


@pytest.fixture
def service() -> Service:
    service = Service("s")
    service.add("way", spec="element")
    service.set("way", '<behavior state="running" left="2"><left>(3 4)</left></behavior>')
    return service


def test_an_attribute_is_a_part(service: Service) -> None:
    assert service.get("way.state") == "running"
    assert service.get("way.properties") == "(state left)"


def test_a_child_comes_before_an_attribute_of_its_name(service: Service) -> None:
    assert service.get("way.left") == "(3 4)"


def test_an_attribute_can_be_set(service: Service) -> None:
    service.set("way.state", "done")
    assert str(service.get("way")).startswith('<behavior state="done" left="2">')


def test_an_attribute_has_no_parts_and_others_are_unknown(service: Service) -> None:
    for name in ("way.state.x", "way.nothing"):
        with pytest.raises(PropertyError, match="no such property"):
            service.get(name)
