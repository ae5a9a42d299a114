"""The page over a linked host: values of ports, services and events there, which act."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, hosts_named, linked
from forked import Commands
from shells import Shell
from waiting import until
from webkit import WebClient, served

pytestmark = [
    NEEDS_HOSTS,
    pytest.mark.timeout(180),  # a bare host is made ready first
]
OUT, IN, NOTES = "/robot1/SeqOut0.rtc", "/localhost/SeqIn0.rtc", "/robot1/notes"

hosts = hosts_named("robot1")


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A shell that is linked to a host, whose values flow here, and which has a service."""
    with linked(commands, hosts) as shell:
        shell.ok("rtmgr -c 'SeqOut?manager_name=eyes' /robot1/manager.mgr")
        shell.ok("rtmgr -c SeqIn /localhost/manager.mgr")
        shell.ok(f"rtcon -i one {OUT}:Long {IN}:Long")
        for each in (OUT, IN):
            shell.ok(f"rtact {each}")
        shell.ok("rtmgr -c 'Storage?instance_name=s0&conf.default.service=notes"
                 "&conf.default.root=/root' /robot1/manager.mgr")  # fmt: skip
        shell.ok("rtact /robot1/s0.rtc")
        until(lambda: "notes" in shell.run("rtget /robot1.services").out, "it is listed there")
        yield shell


@pytest.fixture(scope="module")
def client(fleet: Shell) -> Iterator[WebClient]:
    with served(fleet) as client:
        yield client


def test_values_come_of_ports_of_both_ends_of_a_connector(client: WebClient) -> None:
    with client.stream("one") as stream:
        stream.until(lambda seen: OUT in seen.components and "one" in seen.connectors)
        ports = {f"{OUT}:Long", f"{IN}:Long"}
        client.post("/api/watch", {"page": "one", "ports": [*ports]})
        first: dict[str, int] = {}
        grown: set[str] = set()
        while grown != ports:
            for port, sample in stream.next("values")["values"].items():
                if sample["count"] > first.setdefault(port, sample["count"]):
                    grown.add(port)


def test_what_is_done_there_is_done_and_told_as_it_happens(client: WebClient, fleet: Shell) -> None:
    with client.stream() as stream:
        stream.until(lambda seen: OUT in seen.components)
        client.do({"do": "deactivate", "component": OUT})
        stream.until(lambda seen: seen.components[OUT]["word"] == "Inactive")
        assert "Inactive" in fleet.ok(f"rtls -l {OUT}")
        client.do({"do": "activate", "component": OUT})
        stream.until(lambda seen: any(e["event"] == "ACTIVE" for e in seen.events))
    told = client.ask("GET", "/api/events?since=0").body["events"]
    assert {e["event"] for e in told if e["path"] == OUT} >= {"INACTIVE", "ACTIVE"}
    past = client.ask("GET", "/api/past").body["changes"]
    assert any(e["path"] == OUT for change in past for e in change["events"])


def test_services_there_are_listed_and_set(client: WebClient, fleet: Shell) -> None:
    assert NOTES in str(client.ask("GET", "/api/properties/services").body["services"])
    client.post("/api/properties/set", {"target": f"{NOTES}.today.txt", "value": "water"})
    assert fleet.ok(f"rtget {NOTES}.today.txt") == "water\n"
