"""Service ports: who calls whom, what an error looks like, in one process and as bytes."""

from __future__ import annotations

from typing import Protocol

import pytest

from rtkit.component import Component, Polarity, PortInterfaceProfile, ServicePort
from rtkit.component.services.invocation import Direct, Remote, answer
from rtkit.errors import Malformed, NotFound, Refused, Unreachable
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.profiles import ConnectorProfile

NOW = 1_000_000_000


class MyService(Protocol):
    def echo(self, text: str) -> str: ...

    def fail(self, how: str) -> None: ...

    def wrong(self) -> int: ...


class Other(Protocol):
    def ping(self) -> int: ...


class Provider(Component):
    """Does what it says."""

    service = ServicePort.provided(MyService, "myservice0")

    def __init__(self, instance, options=None):
        super().__init__(instance, options)
        self.calls = []

    def echo(self, text):
        self.calls.append(text)
        return text.upper()

    def fail(self, how):
        raise {"value": ValueError, "exit": SystemExit, "refused": Refused}[how]("on purpose")

    def wrong(self):
        return "text"


class Consumer(Component):
    """Asks."""

    service = ServicePort.required(MyService, timeout_s=0.5)


def wire(id="w", **properties):
    named = {key.replace("__", "."): value for key, value in properties.items()}
    return ConnectorProfile(id, id, (), named)


def direct(provider):
    return {served.interface.name: Direct(served) for served in provider.service.served}


def remote(provider, sent=None):
    """As between two processes, without any."""

    def send(request, timeout_s):
        if sent is not None:
            sent.append(timeout_s)
        return answer(request, provider.service.served, NOW)

    return {"MyService": Remote("MyService", "Consumer0.service: Provider0.service", send, clock)}


def clock():
    return NOW


@pytest.fixture
def provider():
    return Provider("Provider0")


@pytest.fixture(params=[direct, remote])
def client(provider, request):
    consumer = Consumer("Consumer0")
    consumer.service.attach(wire(), request.param(provider))
    return consumer.service.client


def test_a_call_and_its_answer(client, provider):
    assert client.echo("hi") == "HI"
    assert client.echo(text="ho") == "HO"
    assert provider.calls == ["hi", "ho"]


@pytest.mark.parametrize(
    ("how", "named"),
    [("value", "ValueError"), ("exit", "SystemExit"), ("refused", "Refused")],
)
def test_an_exception_of_the_provider_is_named_with_its_place(client, how, named):
    told = rf"^Provider0.service: MyService.fail failed: {named}: on purpose \(test_service.py:\d+"
    with pytest.raises(Refused, match=told):
        client.fail(how)


def test_arguments_are_checked_before_anything_happens(client, provider):
    with pytest.raises(Malformed, match="echo: missing a required argument"):
        client.echo()
    assert provider.calls == []


def test_between_processes_values_are_checked_too(provider):
    consumer = Consumer("Consumer0")
    consumer.service.attach(wire(), remote(provider))
    with pytest.raises(Malformed, match=r"MyService.echo.text: 5 is not a value of type string"):
        consumer.service.client.echo(5)
    with pytest.raises(Malformed, match=r"Provider0.service: MyService.wrong.result: 'text'"):
        consumer.service.client.wrong()


def test_each_component_has_a_port_of_its_own(provider):
    one, other = Consumer("A"), Consumer("B")
    one.service.attach(wire(), direct(provider))
    assert one.service.is_connected
    assert not other.service.is_connected
    assert other.service.connectors == ()
    assert Provider("P").service.served[0].implementation is not provider


def test_without_provider_a_call_fails_at_once(provider):
    consumer = Consumer("C")
    told = "C.service: no provider of MyService is connected"
    with pytest.raises(Unreachable, match=told):
        consumer.service.client.echo("x")
    consumer.service.attach(wire(), direct(provider))
    consumer.service.detach("w")
    with pytest.raises(Unreachable, match=told):
        consumer.service.client.echo("x")


def test_the_first_provider_connected_is_called_and_the_next_one_after_it(provider):
    consumer, second = Consumer("C"), Provider("Second0")
    consumer.service.attach(wire("a"), direct(provider))
    consumer.service.attach(wire("b"), direct(second))
    consumer.service.client.echo("1")
    consumer.service.detach("a")
    consumer.service.client.echo("2")
    assert (provider.calls, second.calls) == (["1"], ["2"])


def test_time_outs_of_port_connector_and_call(provider):
    consumer, sent = Consumer("C"), []
    consumer.service.attach(wire(), remote(provider, sent))
    consumer.service.client.echo("x")
    consumer.service.within(0.125).echo("x")
    consumer.service.detach("w")
    consumer.service.attach(wire(service__timeout="0.25"), remote(provider, sent))
    consumer.service.client.echo("x")
    assert sent == [0.5, 0.125, 0.25]
    plain = Consumer("D", {"port.service.service.service.timeout": "3"})
    plain.service.attach(wire(), remote(provider, sent))
    plain.service.client.echo("x")
    assert sent[-1] == 3.0


@pytest.mark.parametrize("text", ["0", "-1", "inf", "soon"])
def test_time_outs_that_are_none(text):
    consumer = Consumer("C")
    with pytest.raises(Malformed):
        consumer.service.attach(wire(service__timeout=text))
    assert consumer.service.connectors == ()


def test_an_answer_that_does_not_come_names_both_ends():
    def send(request, timeout_s):
        raise Unreachable(f"no answer within {timeout_s:g} s")

    consumer = Consumer("C")
    target = Remote("MyService", "C.service: P.service", send, clock)
    consumer.service.attach(wire(), {"MyService": target})
    told = "^C.service: P.service: MyService.echo: no answer within 0.5 s$"
    with pytest.raises(Unreachable, match=told):
        consumer.service.client.echo("x")


def test_a_call_that_comes_too_late_is_not_done(provider):
    kept = []

    def send(request, timeout_s):
        kept.append(request)
        return b"ok\n"

    consumer = Consumer("C")
    consumer.service.attach(wire(), {"MyService": Remote("MyService", "", send, clock)})
    with pytest.raises(Malformed):
        consumer.service.client.echo("x")
    reply = answer(kept[0], provider.service.served, NOW + 500_000_001)
    assert reply == b"unreachable\nthe call came when nobody waited for it any more"
    assert provider.calls == []


@pytest.mark.parametrize(
    ("request_", "kind"),
    [
        (b"", b"malformed"),
        (b"no line", b"malformed"),
        (b"a\tb\tc\n", b"malformed"),
        (b"9999999999\tOther\tping()->int64\n", b"not-found"),
        (b"9999999999\tMyService\techo(text:string)->int32\n", b"refused"),
        (b"9999999999\tMyService\tsing()->void\n", b"refused"),
        (b"9999999999\tMyService\techo(text:string)->string\n", b"malformed"),
        (b"9999999999\tMyService\techo(text:string)->string\n\xff\xff\xff\xff", b"malformed"),
    ],
)
def test_whatever_arrives_is_answered(provider, request_, kind):
    assert answer(request_, provider.service.served, NOW).split(b"\n")[0] == kind
    assert provider.calls == []


def test_interfaces_that_differ_are_told_apart(provider):
    class MyService(Protocol):
        def echo(self, text: int) -> int: ...

    class Odd(Component):
        service = ServicePort.required(MyService)

    for targets in (direct(provider), remote(provider)):
        odd = Odd("Odd0")
        odd.service.attach(wire(), targets)
        with pytest.raises(Refused, match=r"interfaces differ: echo is echo\(text:string\)"):
            odd.service.client.echo(1)


def test_profiles_of_ports():
    provided, required = Provider("P").service.profile, Consumer("C").service.profile
    assert provided.interfaces == (
        PortInterfaceProfile("myservice0", "MyService", Polarity.PROVIDED),
    )
    assert required.interfaces == (PortInterfaceProfile("service", "MyService", Polarity.REQUIRED),)
    assert required.properties["service.timeout"] == "0.5"


class Both(Component):
    """Provides one interface and needs another, on one port."""

    both = (
        ServicePort(doc="Two at once.")
        .provide(MyService, "mine", implementation=Provider("Inner0"), type_name="My::Service")
        .require(Other, "its")
    )


def test_several_interfaces_on_one_port():
    both = Both("Both0")
    assert [(i.instance_name, i.type_name) for i in both.both.interfaces] == [
        ("mine", "My::Service"),
        ("its", "Other"),
    ]

    class Pinger(Component):
        port = ServicePort.provided(Other)

        def ping(self):
            return 7

    target = {s.interface.name: Direct(s) for s in Pinger("Pinger0").port.served}
    both.both.attach(wire(), target)
    assert both.both.client_of(Other).ping() == 7
    with pytest.raises(NotFound, match="does not need"):
        both.both.client_of(MyService)


class Counter:
    """An implementation apart from the component."""

    def __init__(self):
        self.count = 0

    def ping(self):
        self.count += 1
        return self.count


def test_a_class_as_implementation_is_made_for_each_component():
    class Apart(Component):
        port = ServicePort.provided(Other, implementation=Counter)

    one, other = Apart("A"), Apart("B")
    assert isinstance(one.port.served[0].implementation, Counter)
    assert one.port.served[0].implementation is not other.port.served[0].implementation


class Servant:
    """An implementation that works for a component."""

    def __init__(self, component, suffix="!"):
        self.component = component
        self.suffix = suffix

    def count(self) -> int:
        """Count."""
        return len(self.component.instance)


def test_a_class_as_implementation_is_given_the_component_it_asks_for():
    class Provider(Component):
        port = ServicePort.provided(Counting, implementation=Servant)

    made = Provider("Provider0").port.served[0].implementation
    assert (made.component.instance, made.suffix, made.count()) == ("Provider0", "!", 9)


class Counting(Protocol):
    """Counts."""

    def count(self) -> int:
        """Count."""


def test_an_implementation_that_lacks_methods_is_refused():
    class Lazy(Component):
        service = ServicePort.provided(MyService)

        def echo(self, text):
            return text

    told = "Lazy0.service: Lazy does not implement MyService: it lacks fail, wrong"
    with pytest.raises(Refused, match=told):
        Lazy("Lazy0")


def test_a_call_is_an_event_for_the_provider(provider):
    made = Provider("P", {"execution_contexts": "EventDriven"})
    made.on_execute = lambda context: None
    made.initialize()
    context = made.contexts["0"]
    context.activate_component(made)
    while context.is_due:
        context.tick()
    assert context.state_of(made) is LifeCycleState.ACTIVE
    consumer = Consumer("C")
    consumer.service.attach(wire(), direct(made))
    consumer.service.client.echo("x")
    assert context.is_due


def test_in_one_process_the_object_itself_arrives(provider):
    text = "same object"
    consumer = Consumer("C")
    consumer.service.attach(wire(), direct(provider))
    consumer.service.client.echo(text)
    assert provider.calls[0] is text
