"""Managers reached from another host over mutual TLS: who may do what, and that the port lives."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import ssl
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from faultkit import Order, Points
from forked import Commands
from robotkit import AT, BOUND_S, Robot, opened_robot
from waiting import until

from rtkit.errors import Refused, RtkitError
from rtkit.keys import audit, authority
from rtkit.keys.authority import issue, revoke
from rtkit.manager.gateway.relay import LIMITS
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer
from rtkit.tree.secure_link import IDENTITY
from rtkit.wires.secure import connected

FLOOD = 300


@pytest.fixture(scope="module")
def robot(commands: Commands) -> Iterator[Robot]:
    with opened_robot(commands) as robot:
        yield robot


# Who may do what

LOOKS = ("rtls -l AT", "rtls -R AT", "rtcat AT/ConsoleIn0.rtc",
         "rtconf AT/ConsoleIn0.rtc", "rtget AT/ConsoleIn0.rtc.state",
         "rtattach --show AT/ConsoleIn0.rtc")  # fmt: skip
CHANGES = {
    "rtact AT/ConsoleIn0.rtc": "activate ConsoleIn0",
    "rtdeact AT/ConsoleIn0.rtc": "deactivate ConsoleIn0",
    "rtconf AT/ConsoleIn0.rtc set values 1": "set parameters ConsoleIn0, activate set ConsoleIn0",
    "rtcon -i c1 AT/ConsoleIn0.rtc:out AT/ConsoleOut0.rtc:in":
        "connect ConsoleIn0.out and ConsoleOut0.in",
    "rtdis -i c1 AT/ConsoleIn0.rtc:out": "disconnect c1",
}  # fmt: skip
TYPES = "rtattach -t 0.01 --send hunter2 AT/ConsoleIn0.rtc"
MAKES = {
    "rtmgr -c 'ConsoleIn?instance_name=New&password=hunter2' AT/manager.mgr": "create ConsoleIn",
    "rtmgr -d New AT/manager.mgr": "delete New",
    "rtmgr -l ./nothing.py:init AT/manager.mgr": "load ",
    "rtmgr -s a.b=c AT/manager.mgr": "set a.b",
    "rtmgr --fork AT/manager.mgr": "set fork",
}


def test_each_role_does_what_it_may_and_no_more(robot: Robot) -> None:
    for line in LOOKS:
        for who in ("anna", "bert", "carl", "owner1"):
            done = robot.by(who, line)
            assert (done.status, done.err) == (0, ""), (who, line)
    for line, what in CHANGES.items():
        for who, role in (("anna", "viewer"), ("carl", "component")):
            done = robot.by(who, line)
            assert done.status == 1
            assert f"denied: {who} ({role}) may not {what}: it takes operator" in done.err
        done = robot.by("bert", line)
        assert (done.status, done.err) == (0, ""), line
    for line, what in MAKES.items():
        done = robot.by("bert", line)
        assert done.status == 1
        assert f"denied: bert (operator) may not {what}" in done.err
        assert "it takes administrator" in done.err
    for line in list(MAKES)[:2]:
        assert robot.by("owner1", line).err == ""


def test_what_is_done_and_denied_is_on_record(robot: Robot) -> None:
    begun = len(robot.record()) if (robot.shell.folder / "robot.state/audit.jsonl").exists() else 0
    robot.by("anna", "rtls AT")
    robot.by("anna", "rtact AT/ConsoleIn0.rtc")
    robot.by("bert", "rtreset AT/ConsoleIn0.rtc")
    robot.by("owner1", "rtmgr -c 'ConsoleIn?instance_name=X&password=hunter2' AT/manager.mgr")
    robot.by("owner1", "rtmgr -d X AT/manager.mgr")
    lines = robot.record()[begun:]
    assert [(each["name"], each["what"], each["result"].split(":")[0]) for each in lines] == [
        ("anna", "activate ConsoleIn0 at manager", "denied"),
        ("bert", "reset ConsoleIn0 at manager", "done"),
        ("owner1", "create ConsoleIn at manager", "done"),
        ("owner1", "delete X at manager", "done"),
    ]
    assert {each["wire"] for each in lines} == {"tls"}
    assert "hunter2" not in str(lines)


def test_typing_at_a_terminal_takes_an_operator_and_what_is_typed_is_not_on_record(
    robot: Robot,
) -> None:
    begun = len(robot.record()) if (robot.shell.folder / "robot.state/audit.jsonl").exists() else 0
    denied = robot.by("anna", TYPES)
    assert "denied: anna (viewer) may not type to ConsoleIn0: it takes operator" in denied.err
    assert "ConsoleIn0 has not read it within 0.01 s: 8 bytes" in robot.by("bert", TYPES).err
    lines = robot.record()[begun:]
    assert [(each["name"], each["what"]) for each in lines] == [
        ("anna", "type to ConsoleIn0 at manager"),
        ("bert", "type to ConsoleIn0 at manager"),
    ]
    assert "hunter2" not in str(lines)


def test_secrets_are_for_administrators(robot: Robot) -> None:
    made = (
        "rtmgr -c 'ConsoleIn?instance_name=X&password=hunter2&conf.default.token=h3' AT/manager.mgr"
    )
    robot.by("owner1", made)
    targets = ("%40x%2Fsnapshot", "%40x%2Fpicture", "%40x%2Fevents%2FX", "%40x%2Fpart%2FX")
    for who in ("anna", "bert"):
        with robot.connected(who) as client:
            texts = [str(client.ask(target).value()) for target in targets]
        assert all("(hidden)" in text for text in texts)
        assert not any("hunter" in text for text in texts)
    with robot.connected("owner1") as client:
        assert "hunter2" in str(client.ask(targets[2]).value())
    assert robot.by("owner1", "rtmgr -d X AT/manager.mgr").err == ""


def test_who_is_denied_often_does_not_wash_out_the_record(robot: Robot) -> None:
    with robot.connected("carl") as client:
        for _ in range(200):
            assert client.ask("%40%2Fstop", "").error == "denied"
    assert len([each for each in robot.record() if each["name"] == "carl"]) <= audit.MOST_DENIED


def test_a_batch_takes_the_role_of_its_greatest_action(robot: Robot) -> None:
    mixed = json.dumps({"actions": [
        {"do": "ChangeState", "instance": "ConsoleIn0", "context": "0", "transition": "activate"},
        {"do": "Delete", "instance": "ConsoleOut0"},
    ], "ordered": True, "timeout": 5})  # fmt: skip
    with robot.connected("bert") as client:
        answer = client.ask("%40%2Fbatch", mixed)
    assert answer == Answer(
        "bert (operator) may not delete ConsoleOut0: it takes administrator", "denied"
    )
    assert "Inactive" in robot.by("anna", "rtls -l AT").out


ODD = {
    "%40%2F**": "malformed", "%40%2F": "malformed", "%40x%2F%2A": "malformed", "": "malformed",
    "..%2Fother%2F%40%2Fmanager.pid": "malformed", "manager.pid": "malformed", "%FF": "malformed",
    "%40x%2Fhalf": "refused", "%40x%2Fdump": "denied", "%40x%2Flacking": "denied",
    "%40%2Fmanager.pid%00": "malformed", "%40%2F" + "a" * 2000: "malformed",
    "%40x%2Fsnapshot.listen": "denied", "%40%2Fno.such": "not-found",
}  # fmt: skip


@pytest.mark.parametrize("target", ODD)
def test_odd_requests_are_answered_and_no_more(robot: Robot, target: str) -> None:
    with robot.connected("bert") as client:
        answer = client.ask(target, "self" if target.endswith(".listen") else None)
        assert answer.error == ODD[target], answer
        assert client.ask("%40%2Fmanager.instance_name") == Answer("manager")


def test_what_is_for_programs_of_its_own_host_is_for_nobody_else(robot: Robot) -> None:
    with robot.connected("owner1") as client:
        assert client.ask("%40x%2Fhalf", "{}").error == "refused"
        for pipe in ("/proc/1/fd/1", "/proc/1/fd/1 forget", "{}", " "):
            assert client.ask("%40%2Frestart", pipe).error == "refused"
        assert robot.is_alive()


RUBBISH = {
    "no json": "]", "deep": "[" * 200_000, "no batch": "{}", "long": "9" * (3 << 20),
    "unknown": '{"actions": [{"do": "Explode"}], "ordered": true, "timeout": 1}',
}  # fmt: skip


@pytest.mark.parametrize("text", RUBBISH.values(), ids=RUBBISH)
def test_rubbish_in_a_batch_is_refused(robot: Robot, text: str) -> None:
    with robot.connected("owner1") as client:
        assert client.ask("%40%2Fbatch", text).error in ("malformed", "internal")
        assert client.ask("%40%2Fmanager.instance_name") == Answer("manager")


def test_a_request_that_is_too_large_ends_its_connection_only(robot: Robot) -> None:
    with robot.connected("owner1") as client, contextlib.suppress(RtkitError):
        assert client.ask("%40%2Fbatch", "{" + "9" * (5 << 20)).error == "too-large"
    assert robot.is_alive()


# Strangers


def test_no_certificate_is_let_in(robot: Robot) -> None:
    context = ssl.create_default_context(cafile=f"{robot.keys}/ca.crt")
    with (
        context.wrap_socket(robot.raw(), server_hostname=AT) as tls,
        pytest.raises((ssl.SSLError, ConnectionError)),
    ):
        _asked(tls)
    assert robot.by("nobody", "rtls AT").err.startswith(
        f"rtls: {robot.path[1:]} is on another host: no keys: "
    )
    assert robot.is_alive()


def _asked(tls: ssl.SSLSocket) -> bytes:
    tls.sendall(f"GET {IDENTITY}\n".encode())
    return tls.recv(100)


def test_another_ca_is_let_in_nowhere(robot: Robot) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", f"{robot.keys}.eve")
        authority.init("eve", ["localhost", AT])
    done = robot.by("eve", "rtls AT")
    assert (done.status, done.out) == (1, "")
    assert "is not trusted" in done.err
    # One that takes this CA for good, but has no certificate of it.
    for name in ("ca.crt", "revoked.crl"):
        Path(f"{robot.keys}.eve", name).write_bytes(Path(robot.keys, name).read_bytes())
    done = robot.by("eve", "rtls AT")
    assert (done.status, done.out) == (1, "")
    assert "it does not know the CA" in done.err or "it wants a certificate" in done.err
    assert robot.is_alive()


def test_who_is_revoked_is_cut_and_comes_in_no_more(robot: Robot) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", robot.keys)
        issue("dora", "operator", [], 30, f"{robot.keys}.dora")
        with robot.connected("dora") as client:
            assert client.ask("%40%2Fmanager.instance_name") == Answer("manager")
            revoke("dora")
            told = Path(robot.keys, "revoked.crl").read_bytes()
            Path(f"{robot.keys}.robot1", "revoked.crl").write_bytes(told)
            with pytest.raises(RtkitError, match="ended"):
                client.event(BOUND_S)
    done = robot.by("dora", "rtls AT")
    assert (done.status, done.out) == (1, "")
    assert "denied: the certificate of dora is revoked" in done.err
    assert robot.is_alive()


def test_a_certificate_that_has_expired_is_denied(robot: Robot) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", robot.keys)
        issue("old", "administrator", [], 0, f"{robot.keys}.old")
    until(lambda: "has expired" in robot.by("old", "rtls AT").err, "the certificate ends")
    assert robot.is_alive()


def test_the_port_is_open_to_nobody_who_is_not_named_in_its_certificate(robot: Robot) -> None:
    """127.0.0.3 leads nowhere; ``localhost`` is not what robot1 was issued for."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", robot.keys)
        real = socket.create_connection
        patch.setattr(socket, "create_connection", lambda _at, *more: real((AT, robot.port), *more))
        with pytest.raises(PropertyError, match="is not trusted"):
            connected("robot9", robot.port, BOUND_S)


# The port lives on


def _ends(end: socket.socket) -> None:
    with contextlib.suppress(ConnectionError):
        while end.recv(4096):
            pass


def test_broken_handshakes_do_not_close_the_port(robot: Robot) -> None:
    """As many as shut the listener of the transport itself: it reads none of them."""
    hello = ssl.MemoryBIO()
    tls = ssl.create_default_context().wrap_bio(ssl.MemoryBIO(), hello, server_hostname=AT)
    with contextlib.suppress(ssl.SSLWantReadError):
        tls.do_handshake()
    greeting = hello.read()
    for number in range(FLOOD):
        with robot.raw() as end:
            said = (
                b"",
                b"\0",
                b"GET / HTTP/1.1\r\n\r\n",
                greeting[: number % len(greeting)],
                greeting,
            )
            with contextlib.suppress(OSError):
                end.sendall(said[number % len(said)])
    assert robot.is_alive()


def test_handshakes_that_never_end_keep_nobody_out(robot: Robot) -> None:
    with contextlib.ExitStack() as ends:
        for _ in range(FLOOD):
            ends.enter_context(robot.raw()).sendall(b"\x16\x03\x01\x02\x00\x01")
        assert robot.is_alive()
    assert robot.is_alive()


def test_a_handshake_byte_by_byte_holds_up_nobody(robot: Robot) -> None:
    with robot.raw() as slow:
        over = threading.Event()

        def drip() -> None:
            with contextlib.suppress(OSError):
                for byte in b"\x16\x03\x01\x02\x00\x01" + bytes(500):
                    if over.wait(0.01):
                        return
                    slow.sendall(bytes([byte]))

        thread = threading.Thread(target=drip)
        thread.start()
        assert robot.is_alive()
        over.set()
        thread.join()


def test_whoever_asks_too_often_is_slowed_down_and_refused_nothing(robot: Robot) -> None:
    with robot.connected("anna") as client:
        end = client.detach()
        count = 2 * LIMITS.rate
        asking = threading.Thread(
            target=end.sendall, args=(b"GET %40%2Fmanager.instance_name\n" * count,)
        )
        asking.start()
        received = b""
        while received.count(b"\n") < count:
            received += end.recv(1 << 16)
        asking.join()
        assert received == b"= manager\n" * count
        assert robot.is_alive()


def test_whoever_has_most_connections_makes_room_for_others(robot: Robot) -> None:
    with contextlib.ExitStack() as ends:
        held = [ends.enter_context(robot.connected("carl")) for _ in range(LIMITS.connections + 5)]
        assert robot.by("owner1", "rtls AT").err == ""
        assert robot.by("owner1", "rtmgr -s port.a=b AT/manager.mgr").err == ""
        assert held[-1].ask("%40%2Fmanager.instance_name") == Answer("manager")


def _resident_kb(pid: int) -> int:
    text = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    return int(text.partition("VmRSS:")[2].split()[0])


def test_who_asks_much_and_reads_nothing_fills_no_memory(robot: Robot) -> None:
    """Each answer has 100 kB; all that are asked for at once would be 50 MB."""
    assert robot.by("owner1", f"rtmgr -s port.a={'x' * 100_000} AT/manager.mgr").err == ""
    gateway = robot.gateway()
    before = _resident_kb(gateway)
    with robot.connected("anna") as client:
        end = client.detach()
        ask = "".join(f"#{number} GET %40%2Fget_configuration\n" for number in range(480))
        end.sendall(ask.encode())
        for _ in range(3):
            assert robot.is_alive()
        assert _resident_kb(gateway) - before < 30_000
    assert robot.by("owner1", "rtmgr -s port.a= AT/manager.mgr").err == ""


def test_a_gateway_that_is_killed_comes_again(robot: Robot) -> None:
    gateway = robot.gateway()
    os.kill(gateway, signal.SIGKILL)
    until(lambda: robot.by("anna", "rtls AT").status == 0, "the port is open again")
    assert robot.gateway() != gateway


# What else commands do there


def test_what_happens_there_is_told(robot: Robot) -> None:
    with robot.keys_of("anna"):
        watch = robot.shell.open(f"rtwatch -v -n 1 {robot.path}/ConsoleOut0.rtc")
    assert watch.stderr is not None
    assert "listening" in watch.stderr.readline()
    assert robot.by("bert", "rtact AT/ConsoleOut0.rtc").err == ""
    out, _ = watch.communicate(timeout=BOUND_S)
    assert f" {robot.path}/ConsoleOut0.rtc 0 ACTIVE" in out
    assert f"{robot.path[1:]}/ConsoleOut0.rtc" in robot.by("anna", "rttop --once AT").out
    assert robot.by("bert", "rtdeact AT/ConsoleOut0.rtc").err == ""


def test_who_listens_is_told_when_the_manager_is_back(robot: Robot) -> None:
    assert robot.there(f"rtmgr start manager3 -a --tls {AT}:0") == (0, "", "")
    port = robot.port_of("manager3")
    with robot.keys_of("owner1"):
        watch = robot.shell.open(f"rtwatch -v /{AT}:{port}")
    assert watch.stderr is not None
    assert "listening" in watch.stderr.readline()
    assert robot.there("rtmgr stop manager3") == (0, "", "")
    assert "waiting for it to come back" in watch.stderr.readline()
    assert robot.there(f"rtmgr start manager3 -a --tls {AT}:{port}") == (0, "", "")
    assert "is back" in watch.stderr.readline()
    watch.send_signal(signal.SIGINT)
    watch.communicate(timeout=BOUND_S)
    assert robot.there("rtmgr stop manager3") == (0, "", "")


def test_a_manager_is_restarted_by_administrators(robot: Robot) -> None:
    line = f"rtmgr start manager4 -a --tls {AT}:0 -o manager.components.precreate:ConsoleIn,No"
    assert robot.there(line).status == 1  # there is no type No
    port = robot.port_of("manager4")
    assert robot.by("bert", f"rtact /{AT}:{port}/ConsoleIn0.rtc").err == ""
    for who in ("anna", "bert"):
        done = robot.by(who, f"rtmgr restart {AT}:{port}")
        assert (done.status, done.out) == (1, "")
        assert "may not set restart: it takes administrator" in done.err
    for word, state in (("", "Active"), ("--forget", "Inactive")):
        done = robot.by("owner1", f"rtmgr restart {word} {AT}:{port}")
        assert (done.status, done.out) == (1, "")
        assert "component type No is not known" in done.err
        assert f"manager {AT}:{port} runs" in done.err
        assert state in robot.by("anna", f"rtls -l /{AT}:{port}").out
    told = [each for each in robot.record() if each["what"] == "set restart at manager4"]
    assert [each["result"] for each in told] == ["denied", "denied", "done", "done"]
    assert robot.there("rtmgr stop manager4") == (0, "", "")


def test_the_manager_of_that_name_here_is_another_one(robot: Robot) -> None:
    """To stop the one at an address stops that one, though one of its name runs here."""
    robot.shell.ok("rtmgr start")
    assert robot.by("bert", f"rtmgr stop {AT}:{robot.port}").err.endswith(
        "it takes administrator\n"
    )
    done = robot.by("owner1", f"rtmgr uninstall {AT}:{robot.port}")
    assert "on that host only" in done.err
    told = robot.by("anna", f"rtmgr status --json {AT}:{robot.port}").out
    assert json.loads(told)["pid"] == robot.pid()
    assert robot.there(f"rtmgr start manager2 -a --tls {AT}:0") == (0, "", "")
    at = f"{AT}:{robot.port_of('manager2')}"
    robot.shell.ok("rtmgr start manager2")
    assert robot.by("owner1", f"rtmgr stop {at}") == (0, "", "")
    assert robot.there("rtmgr status manager2").status == 1
    assert robot.shell.run("rtmgr status manager2").status == 0
    robot.shell.ok("rtmgr stop manager2")
    robot.shell.ok("rtmgr stop")


def test_the_answer_to_stop_comes_though_its_port_closes_meanwhile(robot: Robot) -> None:
    points = Points(robot.shell.folder / "points")
    robot.more = points.variable
    assert robot.there(f"rtmgr start manager2 -a --allow-faults --tls {AT}:0") == (0, "", "")
    robot.more = {}
    at = f"{AT}:{robot.port_of('manager2')}"
    points.arm(*(Order("gateway.answered", n, "delay", "0.5") for n in range(1, 9)))
    assert robot.by("owner1", f"rtmgr stop {at}") == (0, "", "")
    assert points.has_struck(1)


def test_without_keys_or_port_no_manager_starts(robot: Robot) -> None:
    robot.shell.environment["RTKIT_KEYS"] = str(robot.shell.folder / "none")
    done = robot.shell.run(f"rtmgr start other -a --tls {AT}:0")
    del robot.shell.environment["RTKIT_KEYS"]
    assert done.status == 1
    assert "no keys: " in done.err
    with socket.create_server((AT, 0)) as taken:
        done = robot.there(f"rtmgr start other -a --tls {AT}:{taken.getsockname()[1]}")
    assert done.status == 1
    assert "cannot listen on port" in done.err
    assert robot.there("rtmgr status other").status == 1
    assert robot.there("rtmgr start other --tls host:1").err == (
        "rtmgr: net.tls: not [ADDRESS:]PORT with a numeric address (0.0.0.0 is all): host:1\n"
    )


def test_a_port_of_this_host_is_reached_by_its_certificate(robot: Robot) -> None:
    with robot.keys_of("owner1"):
        robot.shell.ok("rtmgr start other -a --tls 0")
        port = json.loads(robot.shell.ok("rtmgr status --json other"))["tls"].rpartition(":")[2]
        assert robot.shell.ok(f"rtls /localhost:{port}") == "other.mgr/\n"
        robot.shell.ok("rtmgr stop other")


def test_who_is_refused_is_told_so_to_scripts(robot: Robot) -> None:
    import rtkit

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", f"{robot.keys}.anna")
        with rtkit.connect(f"{AT}:{robot.port}") as tree:
            assert "ConsoleIn0.rtc" in str(tree.ls(robot.path))
            with pytest.raises(Refused, match=r"denied: anna \(viewer\) may not activate"):
                tree.activate(f"{robot.path}/ConsoleIn0.rtc")


def test_what_a_manager_makes_is_for_this_user_alone_whatever_the_umask(robot: Robot) -> None:
    """Its sockets take the umask: the folder they lie in shuts out others."""
    line = f"rtmgr start open -a --tls {AT}:0"
    with robot.at_home():
        assert robot.shell.open(line, "import os; os.umask(0); ").wait(BOUND_S) == 0
    try:
        assert robot.there("rtmgr -c 'ConsoleIn?manager_name=s' /localhost/open.mgr").err == ""
        with robot.connected("anna", robot.port_of("open")) as client:
            assert client.ask("%40%2Fstop", "").error == "denied"
        for name in ("robot.run", "robot.state"):
            folder = robot.shell.folder / name
            assert folder.stat().st_mode & 0o077 == 0
            files = [each for each in folder.rglob("*") if each.is_file() and not each.is_symlink()]
            assert any(each.name.startswith("open.") for each in files)
            assert [each for each in files if each.stat().st_mode & 0o077] == []
    finally:
        assert robot.there("rtmgr stop open") == (0, "", "")
