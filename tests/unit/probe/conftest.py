"""A tree of a small world."""

from __future__ import annotations

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.rtc.enums import PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import PortProfile, TypeProfile
from rtkit.tree.client import Tree

_LONG = {"dataport.data_type": "IDL:RTC/TimedLong:1.0"}
_TEXT = {"dataport.data_type": "IDL:RTC/TimedString:1.0"}
_IN = PortProfile("in", PortType.IN, _LONG)
_OUT = PortProfile("out", PortType.OUT, _LONG)


@pytest.fixture
def tree() -> Tree:
    types = [
        ComponentPattern(TypeProfile("Std", "Me", "test", "1.0"), (_IN, _OUT)),
        ComponentPattern(TypeProfile("Output", "Me", "test", "1.0"), (_OUT,)),
        ComponentPattern(
            TypeProfile("Text", "Me", "test", "1.0"), (PortProfile("in", PortType.IN, _TEXT),)
        ),
    ]
    return fake_tree(FakeManager(types))
