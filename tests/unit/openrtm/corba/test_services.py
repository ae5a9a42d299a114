"""Servants and consumers of components written for OpenRTM-aist, and native ones beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from openrtm_files import made, write_component

from rtkit.component.services.invocation import Direct, Remote, answer
from rtkit.component.services.service import ServicePort
from rtkit.openrtm.corba.exceptions import SYSTEM_EXCEPTIONS
from rtkit.rtc.profiles import ConnectorProfile

IDL = """
module Test {
  enum Kind { SMALL, LARGE };
  struct Item { string name; double weight; Kind kind; };
  typedef sequence<Item> Items;
  exception Missing { string name; long tries; };
  interface Base { long count(); };
  interface Store : Base {
    void put(in Item item);
    Items all(in Kind kind);
    double weigh(in string name, out Kind kind) raises (Missing);
    oneway void forget();
  };
};
"""
HEAD = "import Store_idl\nimport Test, Test__POA\n"
PROVIDER = """
def __init__(self, manager):
    OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
    self._storePort = OpenRTM_aist.CorbaPort("store")
    self.servant = Store_i()

def onInitialize(self):
    self._storePort.registerProvider("shelf", "Test::Store", self.servant)
    self.addPort(self._storePort)
    return RTC.RTC_OK
"""
SERVANT = """
class Store_i(Test__POA.Store):
    def __init__(self):
        self.items = []

    def count(self):
        return len(self.items)

    def put(self, item):
        item.weight = item.weight + 0.5
        self.items.append(item)

    def all(self, kind):
        return [each for each in self.items if each.kind == kind]

    def weigh(self, name):
        for each in self.items:
            if each.name == name:
                return each.weight, each.kind
        raise Test.Missing(name, 3)

"""
CONSUMER = """
def __init__(self, manager):
    OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
    self._storePort = OpenRTM_aist.CorbaPort("store")
    self.store = OpenRTM_aist.CorbaConsumer(interfaceType=Test.Store)

def onInitialize(self):
    self._storePort.registerConsumer("shelf", "Test::Store", self.store)
    self.addPort(self._storePort)
    return RTC.RTC_OK
"""
WIRE = ConnectorProfile("w", "w", ())


@pytest.fixture(params=["one process", "two"])
def pair(tmp_path: Path, request: pytest.FixtureRequest) -> tuple[Any, Any]:
    """Return the objects of a provider and a consumer that are connected."""
    (tmp_path / "Store.idl").write_text(IDL)
    provider: Any = made(write_component(tmp_path, "Provider", PROVIDER, before=HEAD + SERVANT))
    consumer: Any = made(write_component(tmp_path, "Consumer", CONSUMER, before=HEAD))
    connect(provider.ports["store"], consumer.ports["store"], request.param)
    return provider.servant, consumer.servant


def connect(provider: ServicePort, consumer: ServicePort, how: str) -> None:
    (served,) = provider.served
    target: Any = Direct(served)
    if how == "two":
        target = Remote(
            served.interface.name,
            "label",
            lambda request, _: answer(request, provider.served, 0),
            lambda: 0,
        )
    consumer.attach(WIRE, {served.interface.name: target})


def test_nobody_is_called_before_there_is_a_provider(tmp_path: Path) -> None:
    (tmp_path / "Store.idl").write_text(IDL)
    consumer: Any = made(write_component(tmp_path, "Consumer", CONSUMER, before=HEAD))
    assert consumer.servant.store._ptr() is None


def test_values_are_passed_both_ways(pair: tuple[Any, Any]) -> None:
    provider, consumer = pair
    test = consumer.store.interface.declarations
    item, small, large = (test.value(("Test", each)) for each in ("Item", "SMALL", "LARGE"))
    store = consumer.store._ptr()
    store.put(item("cup", 0.25, small))
    store.put(item("box", 2.0, large))
    assert store.count() == provider.servant.count() == 2
    assert [each.name for each in store.all(large)] == ["box"]
    assert store.weigh("cup") == (0.75, small)


def test_a_declared_exception_arrives_as_itself(pair: tuple[Any, Any]) -> None:
    _, consumer = pair
    missing = consumer.store.interface.declarations.value(("Test", "Missing"))
    with pytest.raises(missing) as caught:
        consumer.store._ptr().weigh("jar")
    assert (caught.value.name, caught.value.tries) == ("jar", 3)


def test_a_servant_of_the_same_process_is_called_itself(tmp_path: Path) -> None:
    (tmp_path / "Store.idl").write_text(IDL)
    provider: Any = made(write_component(tmp_path, "Provider", PROVIDER, before=HEAD + SERVANT))
    consumer: Any = made(write_component(tmp_path, "Consumer", CONSUMER, before=HEAD))
    connect(provider.ports["store"], consumer.ports["store"], "one process")
    assert consumer.servant.store._ptr() is provider.servant.servant


def test_an_operation_that_a_servant_lacks_is_told(tmp_path: Path) -> None:
    (tmp_path / "Store.idl").write_text(IDL)
    provider: Any = made(write_component(tmp_path, "Provider", PROVIDER, before=HEAD + SERVANT))
    consumer: Any = made(write_component(tmp_path, "Consumer", CONSUMER, before=HEAD))
    connect(provider.ports["store"], consumer.ports["store"], "two")
    with pytest.raises(SYSTEM_EXCEPTIONS["NO_IMPLEMENT"]):
        consumer.servant.store._ptr().forget()


def test_arguments_that_do_not_fit_are_refused(pair: tuple[Any, Any]) -> None:
    _, consumer = pair
    store = consumer.store._ptr()
    if store is pair[0].servant:
        return
    with pytest.raises(TypeError, match="weigh takes 1 arguments, not 2"):
        store.weigh("a", "b")
    with pytest.raises(SYSTEM_EXCEPTIONS["BAD_PARAM"]):
        store.put("no item")


def test_another_object_may_be_called_in_its_place(pair: tuple[Any, Any]) -> None:
    _, consumer = pair
    before, other = consumer.store._ptr(), object()
    assert consumer.store.setObject(other)
    assert consumer.store._ptr() is other
    consumer.store.releaseObject()
    assert consumer.store._ptr() is before
