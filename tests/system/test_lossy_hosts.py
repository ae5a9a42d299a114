"""Services of a host whose network loses packets, delays them, or is away for a second."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from farkit import far_hosts
from fleetkit import NEEDS_HOSTS, linked
from forked import Commands
from lossykit import LossyLink
from shells import Shell
from waiting import until

import rtkit
from rtkit.link import host_links
from rtkit.services.resource import Resource
from rtkit.services.world import HomeWorld

pytestmark = [
    NEEDS_HOSTS,
    pytest.mark.timeout(180),
]
ROBOT = "/robot1/robots/r1"


class Site:
    """A robot on another host, and the wire to it."""

    def __init__(self, shell: Shell, wire: LossyLink) -> None:
        self.shell, self.wire = shell, wire

    def why(self) -> str:
        """Return why the host cannot be reached; empty while it is linked."""
        return host_links.read("robot1").why

    def heal(self) -> None:
        self.wire.loss, self.wire.delay_s, self.wire.is_cut = 0.0, 0.0, False


@pytest.fixture(scope="module")
def built(commands: Commands, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """A robot on another host, in a world of this one."""
    with ExitStack() as stack:
        folder = tmp_path_factory.mktemp("far")
        (host,) = stack.enter_context(far_hosts(folder, "robot1", is_lossy=True))
        shell = stack.enter_context(linked(commands, [host]))
        here = stack.enter_context(pytest.MonkeyPatch.context())
        for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
            here.setenv(name, shell.environment[name])
        stack.enter_context(rtkit.serve(HomeWorld(), "world", hosts=["robot1"]))
        values = f"conf.default.service=robots/r1&conf.default.world=/{os.uname().nodename}/world"
        create = f"DifferentialRobot?instance_name=r1&{values}"
        shell.ok(f"rtmgr /robot1/manager.mgr -c '{create}'")
        shell.ok("rtact /robot1/r1.rtc")
        assert host.wire is not None
        site = Site(shell, host.wire)
        stack.callback(site.heal)
        yield site


@pytest.fixture
def site(built: Site) -> Iterator[Site]:
    yield built
    built.heal()
    until(lambda: not built.why(), "the host is linked")


def test_what_is_asked_under_loss_is_done_once_and_answered(site: Site) -> None:
    site.wire.loss = 0.2
    with rtkit.Client(timeout_s=20.0) as client:
        for number in range(1, 31):
            client.set(f"{ROBOT}.velocity.timeout", number)
            assert client.get(f"{ROBOT}.velocity.timeout") == number
    assert site.wire.lost > 0
    assert site.why() == ""


def test_a_velocity_that_is_renewed_under_loss_holds_and_one_that_is_not_ends(site: Site) -> None:
    site.wire.loss = 0.2
    with rtkit.Client(timeout_s=20.0) as client:
        client.set(f"{ROBOT}.velocity.timeout", 1.0)
        heard: list[float] = []
        client.listen(
            f"{ROBOT}.motion", lambda each: heard.append(each.value[0]), queue=1000, mode="all"
        )
        before = client.get(f"{ROBOT}.location")[0]

        def has_gone() -> bool:
            client.set(f"{ROBOT}.velocity", (0.2, 0, 0, 0, 0, 0))
            return bool(client.get(f"{ROBOT}.location")[0] > before + 0.2)

        until(has_gone, "it has gone ahead")
        until(lambda: client.get(f"{ROBOT}.velocity")[0] == 0, "nobody renews it: it ends")
        until(lambda: heard[-1:] == [0], "who listens is told")


def test_a_second_of_outage_is_no_loss_of_the_host(site: Site) -> None:
    with rtkit.Client(timeout_s=20.0) as client:
        codes: list[str] = []
        client.listen(f"{ROBOT}.status", lambda each: codes.append(each.code), queue=100)
        site.wire.is_cut = True
        healing = threading.Timer(1.0, lambda: setattr(site.wire, "is_cut", False))
        healing.start()
        client.set(f"{ROBOT}.velocity.timeout", 3.0)  # while it is away; done when it is back
        assert not site.wire.is_cut
        assert client.get(f"{ROBOT}.velocity.timeout") == 3.0
        assert not any(codes)
    assert site.why() == ""


def test_a_host_whose_answers_are_lost_but_not_its_acknowledgements_is_not_lost(site: Site) -> None:
    with rtkit.Client(timeout_s=20.0) as client:
        site.wire.mute_until = time.monotonic() + 3.5  # TCP there tries again after 3 s, then 6.2 s
        client.set(f"{ROBOT}.velocity.timeout", 3.5)
        assert client.get(f"{ROBOT}.velocity.timeout") == 3.5
    assert site.why() == ""


def test_values_are_stale_while_the_host_is_lost_and_good_again(site: Site) -> None:
    with rtkit.Client(timeout_s=20.0) as client, rtkit.serve({"r1": rtkit.Mount(ROBOT)}, "here"):
        until(lambda: client.get("here.r1.status") == "ready", "it is mounted here")
        codes: list[str] = []
        client.listen("here.r1.status", lambda each: codes.append(each.quality), queue=100)
        site.wire.is_cut = True
        until(lambda: codes[-1:] == ["stale"], "the value is stale")
        with pytest.raises(rtkit.PropertyError, match="host robot1 cannot be reached") as refused:
            client.get("here.r1.status")
        assert refused.value.code == "no-service"
        site.wire.is_cut = False
        until(lambda: codes[-1:] == ["good"], "and good again")
        # The robot itself may still wait for its world here, which it lost, too.
        until(lambda: client.get("here.r1.status") == "ready", "it is as before")


def test_a_lease_of_a_host_that_is_lost_ends(site: Site) -> None:
    resource = Resource(watch="", hosts="")
    contact = rtkit.Element("contact", {"protocol": "zenoh"}, (), ROBOT)
    with rtkit.serve(resource, "resource"), rtkit.Client(timeout_s=20.0) as client:
        site.wire.loss = 0.2
        client.set("resource.r1", rtkit.Element("service", {"type": "robot"}, (contact,)), lease=0)
        found = lambda: [*map(str, client.get("resource.search"))]  # noqa: E731
        looks = [found() for _ in range(20) if not time.sleep(0.1)]
        assert looks == [["r1"]] * 20
        site.wire.loss, site.wire.is_cut = 0.0, True
        until(lambda: found() == [], "it is gone")
        site.wire.is_cut = False


def test_a_slow_network_that_loses_much_is_told_and_linked_again(site: Site) -> None:
    site.wire.loss, site.wire.delay_s = 0.2, 0.1
    with rtkit.Client(timeout_s=20.0) as client:
        for number in range(1, 11):
            until(lambda n=number: is_set(client, n), "it is done, however often it is lost")
        site.wire.loss = site.wire.delay_s = 0.0
        assert client.get(f"{ROBOT}.velocity.timeout") == 10.0


def is_set(client: rtkit.Client, number: int) -> bool:
    """Try to set a number; return whether it was done, else it is told why not."""
    try:
        client.set(f"{ROBOT}.velocity.timeout", number)
    except rtkit.PropertyError as error:
        if error.code not in ("no-service", "timeout"):
            raise
        return False
    return True
