"""TCP doors and several managers: found by port and by name, closed to everybody else."""

from __future__ import annotations

import json
import os
import pwd
import resource
import select
import signal
import socket
import subprocess
import sys
from typing import Any

import pytest
from waiting import until

from rtkit.link import port_holders, tcp_endpoint

SECRET = "door.secret"
STRANGER = """
import json, sys
import zenoh
port, user, password = sys.argv[1:]
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
config.insert_json5("connect/timeout_ms", "0")
config.insert_json5("connect/exit_on_failure", "true")
config.insert_json5("scouting/multicast/enabled", "false")
if user:
    config.insert_json5("transport/auth/usrpwd/user", json.dumps(user))
    config.insert_json5("transport/auth/usrpwd/password", json.dumps(password))
try:
    session = zenoh.open(config)
except zenoh.ZError:
    print("refused")
else:
    print(len([r for r in session.get("**", timeout=2.0) if r.ok]),
          len([r for r in session.get("rt/**/@/manager.pid", timeout=2.0) if r.ok]),
          len([r for r in session.get("rtw/**", timeout=2.0) if r.ok]))
    session.close()
"""


def start(shell: Any, name: str = "", options: str = "") -> int:
    """Start a manager with a door of its own and return its port."""
    port = tcp_endpoint.free_port()
    shell.ok(f"rtmgr start {name} -p {port} {options}")
    return port


def stranger(port: int, user: str = "", password: str = "", prefix: tuple[str, ...] = ()) -> str:
    """Return what somebody gets at a port who knows this much."""
    done = subprocess.run(
        [*prefix, sys.executable, "-c", STRANGER, str(port), user, password],
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def secret(shell: Any) -> list[str]:
    text: str = (shell.folder / "state" / SECRET).read_text()
    return text.strip().split(":")


# the door


@pytest.mark.parametrize(
    "form",
    [
        "corbaloc::localhost:{port}",
        "corbaloc::localhost:{port}/manager",
        "corbaloc:iiop:localhost:{port}/manager",
        "corbaloc:iiop:127.0.0.1:{port}",
        "/localhost:{port}/manager.mgr",
        "localhost:{port}/manager.mgr/",
    ],
)
def test_a_manager_is_commanded_at_its_door(shell: Any, form: str) -> None:
    address = form.format(port=start(shell))
    assert shell.ok(f"rtmgr -c ConsoleIn --print {address}") == "/localhost/ConsoleIn0.rtc\n"
    shell.ok(f"rtmgr -d ConsoleIn0 {address}")
    assert shell.ok("rtls /localhost") == "manager.mgr/\n"


def test_all_commands_work_through_the_door(shell: Any) -> None:
    port = start(shell, "other")
    host = f"/localhost:{port}"
    shell.ok(f"rtmgr -c ConsoleIn -c ConsoleOut?manager_name=s1 {host}/other.mgr")
    shell.ok(f"rtcon {host}/ConsoleIn0.rtc:out {host}/ConsoleOut0.rtc:in")
    shell.ok(f"rtact {host}/ConsoleIn0.rtc {host}/ConsoleOut0.rtc")
    shell.ok(f"rtconf {host}/ConsoleIn0.rtc set values 1,2")
    assert shell.ok(f"rtls -l {host}").splitlines() == [
        "Active  1/1  0/0  1/1  0/0  ConsoleIn0.rtc",
        "Active  1/1  1/1  0/0  0/0  ConsoleOut0.rtc",
        "-       -    -    -    -    other.mgr",
    ]
    assert "Active" in shell.ok(f"rtcat {host}/ConsoleOut0.rtc")
    assert shell.ok(f"rtmgr -c ConsoleIn --print corbaloc::localhost:{port}/other") == (
        f"{host}/ConsoleIn1.rtc\n"
    )
    shell.environment["RTKIT_MANAGER"] = f"localhost:{port}"
    assert "ConsoleIn1.rtc" in shell.ok("rtls /localhost")


def test_an_address_that_means_nobody(shell: Any) -> None:
    port, nobody = start(shell), tcp_endpoint.free_port()
    status, _, err = shell.run(f"rtmgr -c ConsoleIn corbaloc::localhost:{port}/other")
    assert (status, err.count("\n")) == (1, 1)
    assert f"the manager at localhost:{port} is manager, not other" in err
    hint = f"start one there with: rtmgr start NAME -p {nobody}"
    told = f"rtls: no manager of this user listens at localhost:{nobody} ({hint})\n"
    assert shell.run(f"rtls /localhost:{nobody}") == (1, "", told)
    err = shell.run(f"rtls /far:{port}").err
    assert err.startswith(f"rtls: far:{port} is on another host: no keys: ")
    assert shell.run("rtmgr -c X corbaloc:localhost").err == "rtmgr: Invalid corbaloc URL.\n"
    shell.environment["RTKIT_REALM"] = "elsewhere"
    status, _, err = shell.run(f"rtls /localhost:{port}")
    assert (status, err) == (1, "rtls: no manager of this realm answers there\n")
    del shell.environment["RTKIT_REALM"]


def test_the_secret_is_made_once_and_for_its_user_alone(shell: Any) -> None:
    start(shell)
    file = shell.folder / "state" / SECRET
    assert file.stat().st_mode & 0o777 == 0o600
    before = file.read_text()
    start(shell, "two")
    shell.ok("rtmgr stop")
    start(shell)
    assert file.read_text() == before
    assert len(secret(shell)[1]) >= 64


def test_who_does_not_know_the_secret_gets_nothing(shell: Any) -> None:
    port = start(shell)
    user, password = secret(shell)
    assert stranger(port) == "refused"
    assert stranger(port, user) == "refused"
    assert stranger(port, user, password[:-1]) == "refused"
    assert stranger(port, "other", password) == "refused"
    assert stranger(port, user, password) != "refused"
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.sendall(os.urandom(4096))
    shell.ok("rtls /localhost")
    assert stranger(port, user, password) != "refused"


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become somebody else and try")
def test_another_user_gets_nothing(shell: Any) -> None:
    port = start(shell)
    prefix = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups")
    can_try = subprocess.run(
        [*prefix, sys.executable, "-c", "import zenoh"], capture_output=True, check=False
    )
    if can_try.returncode:
        pytest.skip("nobody cannot run this Python")
    shell.folder.chmod(0o755)
    assert stranger(port, prefix=prefix) == "refused"
    file = shell.folder / "state" / SECRET
    read = subprocess.run([*prefix, "cat", str(file)], capture_output=True, check=False)
    assert (read.returncode != 0, read.stdout) == (True, b"")


@pytest.mark.parametrize("mode", [0o640, 0o604])
def test_a_secret_that_others_can_read_is_no_secret(shell: Any, mode: int) -> None:
    file = shell.folder / "state" / SECRET
    file.write_text("me:known\n")
    file.chmod(mode)
    port = tcp_endpoint.free_port()
    told = f"rtmgr: secret can be read by others (mode {mode:o}); remove it: {file}\n"
    assert shell.run(f"rtmgr start -p {port}") == (1, "", told)
    assert list((shell.folder / "run").iterdir()) == []


def test_a_secret_that_is_a_link_is_refused(shell: Any) -> None:
    (shell.folder / "elsewhere").write_text("me:known\n")
    (shell.folder / "state" / SECRET).symlink_to(shell.folder / "elsewhere")
    status, _, err = shell.run(f"rtmgr start -p {tcp_endpoint.free_port()}")
    assert status == 1
    assert "cannot read the secret" in err


def test_a_port_that_was_asked_for_and_is_taken(shell: Any) -> None:
    port = start(shell)
    pid = json.loads(shell.ok("rtmgr status --json"))["pid"]
    told = (
        f"rtmgr: port {port} is in use by rtkit manager (pid {pid});"
        " choose another one with -p, or none with -a\n"
    )
    for options in (f"-p {port}", f"-o corba.endpoints:localhost:{port}"):
        assert shell.run(f"rtmgr start two {options}") == (1, "", told)
    shell.environment["RTKIT_PORT"] = str(port)
    assert shell.run("rtmgr start two") == (1, "", told)
    assert list((shell.folder / "run").glob("two*")) == []
    shell.ok("rtmgr start two -a")


def test_the_usual_port_may_be_taken(shell: Any) -> None:
    """It is only told: the manager can be reached all the same."""
    del shell.environment["RTKIT_PORT"]
    outcome = shell.run("rtmgr start")
    assert (outcome.status, outcome.out) == (0, "")
    if outcome.err:
        assert outcome.err.startswith("rtmgr: warning: port 2810 is in use by ")
    status, _, err = shell.run("rtmgr start two")
    assert (status, err.count("\n")) == (0, 1)
    assert err.startswith("rtmgr: warning: port 2810 is in use by ")
    shell.ok("rtls /localhost/two.mgr")


def test_a_free_port_is_found_and_told(shell: Any) -> None:
    shell.ok("rtmgr start -p 0")
    address = json.loads(shell.ok("rtmgr status --json"))["address"]
    assert shell.ok(f"rtls /{address}") == "manager.mgr/\n"
    shell.ok("rtmgr stop")
    shell.ok("rtmgr start -a")
    assert json.loads(shell.ok("rtmgr status --json"))["address"] == ""


def test_the_door_leads_on_after_a_restart(shell: Any) -> None:
    port = start(shell)
    shell.ok("rtmgr restart")
    assert shell.ok(f"rtls /localhost:{port}") == "manager.mgr/\n"


def test_who_listens_is_found() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
        assert port_holders.port_holder(port) is None
        listener.listen()
        found = port_holders.port_holder(port)
        assert found is not None
        assert (found.uid, found.pid) == (os.getuid(), os.getpid())
        assert str(found).endswith(f"(pid {os.getpid()})")
        assert not tcp_endpoint.is_free(port)
    assert port_holders.port_holder(port) is None
    assert tcp_endpoint.is_free(port)
    name = pwd.getpwuid(0).pw_name
    assert str(port_holders.PortHolder(0)) == f"a process of user {name}"
    assert str(port_holders.PortHolder(4_000_000_000)) == "a process of user 4000000000"


# several managers


def test_managers_of_one_host_see_each_other(shell: Any) -> None:
    port = start(shell)
    shell.ok("rtmgr start other")
    assert shell.ok("rtls /localhost").split() == ["manager.mgr/", "other.mgr/"]
    other = "/localhost/other.mgr"
    assert shell.ok(f"rtmgr -c ConsoleIn --print {other}") == f"{other}/ConsoleIn0.rtc\n"
    shell.ok(f"rtact {other}/ConsoleIn0.rtc")
    shell.ok(f"rtconf {other}/ConsoleIn0.rtc set values 7")
    assert shell.ok(f"rtconf {other}/ConsoleIn0.rtc get values") == "7\n"
    assert shell.ok(f"rtls -l {other}") == "Active  1/0  0/0  1/0  0/0  ConsoleIn0.rtc\n"
    assert shell.ok(f"rtcat {other}").startswith("Name: manager\nInstance name: other\n")
    assert shell.ok("rtls -R /localhost").split("\n\n") == [
        ".:\nmanager.mgr/\nother.mgr/",
        "./manager.mgr:",
        "./other.mgr:\nConsoleIn0.rtc",
        "",
    ]
    assert shell.ok(f"rtls /localhost:{port}") == "manager.mgr/\n"
    shell.environment["RTKIT_MANAGER"] = "other"
    assert "ConsoleIn0.rtc" in shell.ok("rtls /localhost")
    assert shell.ok("rtmgr -c ConsoleIn --print /localhost/manager.mgr") == (
        "/localhost/manager.mgr/ConsoleIn0.rtc\n"
    )


def test_one_command_asks_one_manager(shell: Any) -> None:
    shell.ok("rtmgr start")
    shell.ok("rtmgr start other")
    status, out, err = shell.run("rtact /localhost/A.rtc /localhost/other.mgr/B.rtc")
    assert (status, out) == (1, "")
    assert err == (
        "rtact: /localhost/other.mgr/B.rtc is at another manager"
        " (other instead of the usual one): one command asks one manager\n"
    )


def test_a_manager_that_ended_is_not_shown(shell: Any) -> None:
    for name in ("manager", "other", "third"):
        shell.ok(f"rtmgr start {name}")
    pid = json.loads(shell.ok("rtmgr status --json third"))["pid"]
    pidfd = os.pidfd_open(pid)
    os.kill(pid, signal.SIGKILL)
    assert select.select([pidfd], [], [], 10)[0]
    os.close(pidfd)
    shell.ok("rtmgr stop other")
    assert shell.ok("rtls /localhost") == "manager.mgr/\n"
    assert shell.run("rtls /localhost/other.mgr").err == (
        "rtls: No such object: /localhost/other.mgr\n"
    )
    shell.ok("rtmgr start third")  # it takes over what the killed one left


def test_a_silent_neighbour_is_told_and_holds_up_nobody(shell: Any) -> None:
    shell.ok("rtmgr start")
    shell.ok("rtmgr start other")
    pid = json.loads(shell.ok("rtmgr status --json other"))["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        assert shell.ok("rtls /localhost").split() == ["manager.mgr/", "other.mgr/"]
        listed = shell.ok("rtls -l --timeout 0.5 /localhost").splitlines()
        assert listed[1].endswith("other.mgr  (manager 'other' does not answer within 0.2 s)")
    finally:
        os.kill(pid, signal.SIGCONT)


@pytest.mark.parametrize("variable", ["RTKIT_SERVERS", "RTCTREE_NAMESERVERS"])
def test_servers_are_in_the_tree(shell: Any, variable: str) -> None:
    port, nobody = start(shell, "other"), tcp_endpoint.free_port()
    shell.environment[variable] = f"localhost:{port}; localhost:{nobody}"
    shell.ok(f"rtmgr -c ConsoleIn /localhost:{port}/other.mgr")
    servers = sorted(["localhost", f"localhost:{port}", f"localhost:{nobody}"])
    assert shell.ok("rtls /").split() == [f"{name}/" for name in servers]
    status, listed, told = shell.run("rtls -lR /")
    assert (status, f"rtls: /localhost:{nobody} was not listed: " in told) == (1, True)
    assert "ConsoleIn0.rtc" in listed
    assert f"localhost:{nobody}  (no manager of this user listens at localhost:{nobody} (" in listed
    assert "localhost  (manager 'manager' is not running" in listed
    shell.ok("rtmgr start")
    assert shell.ok("rtls /").split() == [f"{name}/" for name in servers]


def test_a_slave_manager_registers_with_its_master(shell: Any) -> None:
    port = tcp_endpoint.free_port()
    options = f"-o manager.is_master:NO -o corba.master_manager:localhost:{port}"
    shell.ok(f"rtmgr start sub {options} -o manager.update_master_manager.interval:0.05")
    shell.ok(f"rtmgr start -p {port}")
    script = (
        "import rtkit, sys\n"
        "master, slave = rtkit.connect('manager'), rtkit.connect('sub')\n"
        "while not slave.get('get_master_managers'): pass\n"
        "print(master.get('get_slave_managers'), slave.get('get_master_managers'),\n"
        "      master.get('is_master'), slave.get('is_master'))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=shell.environment,
        capture_output=True,
        text=True,
        timeout=30,
        check=True,
    )
    assert done.stdout.split() == ["sub", f"localhost:{port}", "YES", "NO"]
    shell.ok("rtmgr stop sub")
    script = "import rtkit; print(repr(rtkit.connect().get('get_slave_managers')))"
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=shell.environment,
        capture_output=True,
        text=True,
        timeout=30,
        check=True,
    )
    assert done.stdout == "''\n"


# floods, and ends of the process that serves the port

IDLE = 10_000
"""Connections that say nothing; as many as the machine allows."""


def test_thousands_of_idle_connections_keep_no_owner_out(shell: Any) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    port = start(shell)
    before = descriptors_of(endpoint_of(port))
    idle: list[socket.socket] = []
    try:
        for _ in range(min(IDLE, hard - 500)):
            idle.append(socket.create_connection((tcp_endpoint.LOOPBACK, port)))
        for _ in range(50):
            assert shell.ok("rtls --timeout 5 /localhost") == "manager.mgr/\n"
        status, out, err = shell.run(f"rtls localhost:{port}")
        assert (status, out) == (0, "manager.mgr/\n") or "lets nobody in: it is busy" in err
    finally:
        for each in idle:
            each.close()
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    until(lambda: descriptors_of(endpoint_of(port)) <= before, "descriptors are given back")
    assert shell.ok(f"rtls localhost:{port}") == "manager.mgr/\n"


def test_the_process_of_the_port_is_started_again_when_it_is_killed(shell: Any) -> None:
    port = start(shell)
    killed = endpoint_of(port)
    os.kill(killed, signal.SIGKILL)
    assert shell.ok("rtls /localhost") == "manager.mgr/\n"
    until(lambda: endpoint_of(port) not in (0, killed), "another one listens")
    assert shell.ok(f"rtls localhost:{port}") == "manager.mgr/\n"


def test_the_port_of_a_killed_manager_is_had_by_the_next_one(shell: Any) -> None:
    port = start(shell)
    endpoint = endpoint_of(port)
    os.kill(endpoint, signal.SIGSTOP)  # so that it does not hear of the end of its manager
    os.kill(json.loads(shell.ok("rtmgr status --json"))["pid"], signal.SIGKILL)
    shell.ok(f"rtmgr start -p {port}")
    assert shell.ok(f"rtls localhost:{port}") == "manager.mgr/\n"
    assert endpoint_of(port) != endpoint


def endpoint_of(port: int) -> int:
    """Return the process that listens on a port, 0 for none."""
    holder = port_holders.listener(port)
    return 0 if holder is None else holder.pid


def descriptors_of(pid: int) -> int:
    return len(os.listdir(f"/proc/{pid}/fd"))
