"""rtkit made on another host: broken off anywhere, with little room, with strangers for Python."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import threading
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from farkit import FarHost, far_hosts
from fleetkit import NEEDS_HOSTS
from forked import Commands
from forwarding import Forwarder
from shells import ROOT, Shell, opened_shell
from terminal import opened
from waiting import until

from rtkit.errors import RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.hosts import clock, far_program, far_side, link_process, provisioned, wheels
from rtkit.hosts.connection import HostConnection, connect
from rtkit.hosts.host import Host
from rtkit.hosts.provisioned import Provisioned

pytestmark = NEEDS_HOSTS
_BASE = "/root/.local/share/rtkit"


@pytest.fixture
def far(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[FarHost]:
    with far_hosts(tmp_path, "bare") as (host,):
        home = tmp_path / "home"
        _log_in(home, host)
        monkeypatch.setenv("HOME", str(home))
        monkeypatch.setenv("XDG_CACHE_HOME", str(ROOT / ".venv" / "cache"))
        monkeypatch.delenv("SSH_AUTH_SOCK", raising=False)
        yield host


@pytest.fixture
def shell_to(commands: Commands, far: FarHost) -> Iterator[Shell]:
    """A shell with a manager, whose user may log in at the host, which it knows."""
    with opened_shell(commands) as shell:
        _log_in(shell.folder / "home", far)
        shell.environment |= {key: os.environ[key] for key in ("XDG_CACHE_HOME",)}
        shell.environment["HOME"] = str(shell.folder / "home")
        shell.environment.pop("SSH_AUTH_SOCK", None)
        shell.ok(f"rthost add bare root@{far.address}")
        shell.ok("rtmgr start")
        yield shell
        shell.ok("rtmgr stop")


def _log_in(home: Path, host: FarHost) -> None:
    (home / ".ssh").mkdir(parents=True, mode=0o700)
    shutil.copy(host.key, home / ".ssh" / "id_ed25519")
    key = " ".join((host.folder / "hostkey.pub").read_text().split()[:2])
    places = (host.address, "[127.0.0.1]:*")
    (home / ".ssh" / "known_hosts").write_text("".join(f"{each} {key}\n" for each in places))


def _make(connection: HostConnection) -> Provisioned:
    look = far_side.look(connection)
    return provisioned.provision(connection, look)


def _versions(far: FarHost) -> tuple[str, list[str]]:
    """Return the version in use, and those that are complete."""
    current = far.run("sh", "-c", f"readlink {_BASE}/current || true").strip()
    marks = far.run("sh", "-c", f"ls {_BASE}/versions/*/rtkit-complete 2>/dev/null || true")
    return os.path.basename(current), [each.split("/")[-2] for each in marks.split()]


def test_a_cut_connection_leaves_no_half_version_and_nothing_is_sent_twice(far: FarHost) -> None:
    cut = Forwarder(far.address)
    known = Path(os.environ["HOME"], ".ssh", "known_hosts")
    known.write_text(known.read_text().replace("*", str(cut.port)))
    host = Host("bare", "127.0.0.1", "root", cut.port)
    passed, steps = 0, [1_000, 4_000, 9_000, 200_000, *[15_000_000] * 5]
    for after in steps:
        cut.after = after
        passed += after
        try:
            with connect(host, 10.0) as connection:
                done = _make(connection)
            break
        except Unreachable:
            assert _versions(far) == ("", [])
    cut.close()
    assert _versions(far) == (done.id, [done.id])
    assert after == 15_000_000
    assert passed <= 15_300_000 * 3
    assert "rtls" in far.run(f"{_BASE}/current/bin/rtls", "--help")
    with connect(Host("bare", far.address, "root"), 10.0) as connection:
        assert _make(connection) == Provisioned(done.id, False, 0)


def test_a_shell_that_writes_lines_of_its_own_is_no_obstacle(far: FarHost) -> None:
    far.run("sh", "-c", "echo 'printf \"\\033[1mWelcome, {you}\"; echo mind >&2' > /root/.bashrc")
    with connect(Host("bare", far.address, "root"), 10.0) as connection:
        made = _make(connection)
        command = [*far_program.python(connection), "-m", "rtkit.hosts.far_manager"]
        text = far_program.ask(connection, [*command, "start", "manager"], timeout_s=20.0)
        found = json.loads(text)
        assert (found["host"], found["was_running"]) == ("bare", False)
        link_process.open_relay(connection, connection.host)[0].close()
        assert abs(clock.compare(connection).offset_s) < 1.0
        maps = far.run("sh", "-c", "cat /proc/[0-9]*/maps")
        assert f"{_BASE}/versions/{made.id}/" in maps
        assert far_program.ask(connection, [*command, "stop", "manager"], timeout_s=20.0)


def test_a_next_version_sends_only_what_is_new(far: FarHost, tmp_path: Path) -> None:
    with connect(Host("bare", far.address, "root"), 10.0) as connection:
        made = _make(connection)
        shutil.copytree(wheels.cache_folder(), tmp_path / "rtkit" / "wheels")
        (own,) = (tmp_path / "rtkit" / "wheels" / "rtkit").glob("*.whl")
        with zipfile.ZipFile(own, "a") as wheel:
            wheel.writestr("rtkit/next", "")
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("XDG_CACHE_HOME", str(tmp_path))
            then = _make(connection)
    assert then.is_new
    assert then.sent_bytes == own.stat().st_size
    assert set(_versions(far)[1]) == {made.id, then.id}


def test_a_version_of_which_files_are_gone_or_changed_is_made_anew(
    shell_to: Shell, far: FarHost
) -> None:
    shell_to.ok("rtmgr start --host bare")
    made, _ = _versions(far)
    at = f"{_BASE}/current"
    (site,) = far.run("sh", "-c", f"cd {at}; echo lib/python3*/site-packages").split()
    for damage, file in (
        (f"rm {at}/{site}/click/core.py", f"{site}/click/core.py"),
        (f"echo >> {at}/{site}/rtkit/errors.py", f"{site}/rtkit/errors.py"),
        (f"rm {at}/bin/python", "bin/python"),
        (f"echo > {at}/rtkit-complete", "rtkit-complete"),
    ):
        far.run("sh", "-c", damage)
        assert f"Damaged      {file} (rtmgr start" in shell_to.ok("rthost check bare")
        told = shell_to.ok("rtmgr start --host bare")
        assert f"rtkit {made} was damaged there ({file}) and is made anew, 0.0 MB sent" in told
        assert "Damaged" not in shell_to.ok("rthost check bare")
        assert _versions(far)[0] == made
        far.run(f"{at}/bin/rtls", "--help")
        assert f"it runs with rtkit {made}.damaged until --replace has it end" in told
        assert "manager replaced; that of" in shell_to.ok("rtmgr start --host bare --replace")
        assert shell_to.ok("rtmgr start --host bare") == "bare: linked, manager ran already\n"
    # Builds before this one marked a version by its name, and listed no files.
    far.run("sh", "-c", f"cp {at}/rtkit-complete /tmp; printf %s {made} > {at}/rtkit-complete")
    assert "Damaged" not in shell_to.ok("rthost check bare")
    far.run("cp", "/tmp/rtkit-complete", f"{at}/rtkit-complete")
    shell_to.ok("rtmgr stop --host bare")
    # What is left of a try that was broken off is no obstacle, and what was sent is not lacking.
    far.run("sh", "-c", f"mkdir {_BASE}/versions/{made}.draft; rm {at}/{site}/click/*.py")
    far.run("sh", "-c", f"rm {_BASE}/wheels/click-*")
    told = shell_to.ok("rtmgr start --host bare")
    assert "and is made anew, 0.1 MB sent" in told
    assert far.run("ls", f"{_BASE}/versions").split() == [made]
    shell_to.ok("rtmgr stop --host bare")


def test_old_versions_go_when_nothing_uses_them_but_for_the_last(far: FarHost) -> None:
    far.run("mkdir", "-p", *(f"{_BASE}/versions/{each}/bin" for each in ("1", "2", "3")))
    far.run("ln", "-s", "versions/2", f"{_BASE}/current")
    far.run("cp", "/bin/sleep", f"{_BASE}/versions/3/bin/python")
    far.run("sh", "-c", f"{_BASE}/versions/3/bin/python 60 > /dev/null 2>&1 &")
    with connect(Host("bare", far.address, "root"), 10.0) as connection:
        made = _make(connection)
    assert set(far.run("ls", f"{_BASE}/versions").split()) == {"2", "3", made.id}


def test_a_stranger_for_python_and_a_full_disk_are_told(
    far: FarHost, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refusal(python: str = "python3") -> str:
        host = Host("bare", far.address, "root", python=python)
        with connect(host, 10.0) as connection, pytest.raises(RtkitError) as told:
            _make(connection)
        return str(told.value)

    for name, text in {
        "endless": "exec yes",
        "liar": 'echo "$2{\\"python\\": [4]}"',
        "broken": "printf '\\033[31mno such thing\\n' >&2; exit 3",
    }.items():
        far.run("sh", "-c", f"printf '%s\\n' '#!/bin/sh' \"$1\" > /root/{name}", "-", text)
        far.run("chmod", "+x", f"/root/{name}")
    assert "it writes without end" in refusal("/root/endless")
    assert "says no sense" in refusal("/root/liar")
    assert "no such thing" in refusal("/root/broken")
    assert "No such file" in refusal("/root/none")
    monkeypatch.setattr(far_side, "_ROOM", 0)
    far.run("mount", "-o", "remount,size=20m", "/root")
    assert "cannot write /root/.local" in refusal()
    far.run("mount", "-o", "remount,size=60m", "/root")
    assert "rtkit cannot be made there: No space left on device" in refusal()
    assert _versions(far) == ("", [])
    far.run("mount", "-o", "remount,size=600m", "/root")
    far.run("mount", "-o", "remount,ro", "/root")
    assert "nothing can be written" in refusal()


def test_a_command_that_is_killed_at_any_step_is_typed_again(shell_to: Shell, far: FarHost) -> None:
    _kill_at_each_step(shell_to, far)
    shell_to.ok("rtmgr start --host bare")
    assert shell_to.ok("rtls /bare").split() == ["manager.mgr/"]
    shell_to.ok("rtmgr stop --host bare")


_STEPS = ("looked", "asked", "wheel", "sent", "used", "started")


def _kill_at_each_step(shell: Shell, far: FarHost) -> None:
    for step, folder in _at_each_step(shell, "kill"):
        killed = shell.open("rtmgr start --host bare")
        assert killed.wait(60.0) == -signal.SIGKILL, step
        assert (folder / "struck").exists()
        current, complete = _versions(far)
        assert complete == ([current] if step in ("used", "started") else [])


def _at_each_step(shell: Shell, action: str) -> Iterator[tuple[str, Path]]:
    """Order an action for the first pass of each step; yield it, and the folder of faults."""
    folder = shell.folder / "faults"
    folder.mkdir(mode=0o700)
    shell.environment["RTKIT_FAULT"] = str(folder)
    for step in _STEPS:
        (folder / "orders").write_text(f"provision.{step} 1 {action}\n")
        for name in ("passed", "struck"):
            (folder / name).unlink(missing_ok=True)
        yield step, folder
    del shell.environment["RTKIT_FAULT"]


def test_a_session_that_the_sshd_drops_at_any_step_is_told_and_done_again(
    shell_to: Shell, far: FarHost
) -> None:
    for step, folder in _at_each_step(shell_to, "stop"):
        dropped = shell_to.open("rtmgr start --host bare")
        until((folder / "struck").exists, f"{step}: the command stands still")
        far.run("sh", "-c", "pkill -f '[s]shd: root'; true")
        os.kill(dropped.pid, signal.SIGCONT)
        if step == "started":  # all is done there, and the link has a connection of its own
            assert dropped.wait(60.0) == 0
            break
        assert dropped.wait(60.0) == 1, step
        assert dropped.stderr is not None
        told = dropped.stderr.read()
        assert "rtmgr: bare" in told or "rtmgr: the connection to bare has ended" in told
        assert "Traceback" not in told
        current, complete = _versions(far)
        assert complete == ([current] if step == "used" else [])
    assert shell_to.ok("rtls /bare").split() == ["manager.mgr/"]
    shell_to.ok("rtmgr stop --host bare")


def test_a_link_goes_neither_to_somebody_in_between_nor_in_without_a_key(
    shell_to: Shell, far: FarHost
) -> None:
    far.run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", "/root/another")
    far.sshd(2203, key="/root/another")
    between = Forwarder(far.address)
    known = shell_to.folder / "home" / ".ssh" / "known_hosts"
    known.write_text(known.read_text().replace("*", str(between.port)))
    shell_to.ok(f"rthost add bare root@127.0.0.1:{between.port} --force")
    shell_to.ok("rtmgr start --host bare")
    for there, back, why in (
        (lambda: between.lead(2203), lambda: between.lead(22), "its key has changed: ssh-ed25519"),
        (
            lambda: far.run("mv", "/root/.ssh/authorized_keys", "/root/keys"),
            lambda: far.run("mv", "/root/keys", "/root/.ssh/authorized_keys"),
            "user root is not let in: it takes none of the keys",
        ),
    ):
        there()
        between.cut()
        until(lambda why=why: why in shell_to.run("rtls /bare").err, why)
        assert why in shell_to.run("rtmgr start --host bare").err
        back()
        shell_to.ok("rtmgr start --host bare")
        shell_to.ok("rtls /bare")
    shell_to.ok("rtmgr stop --host bare")
    between.close()


def test_a_key_that_the_manager_cannot_open_ends_the_wait_for_its_link(shell_to: Shell) -> None:
    key = shell_to.folder / "home" / ".ssh" / "id_ed25519"
    change = ["ssh-keygen", "-q", "-p", "-f", str(key)]
    subprocess.run([*change, "-N", "secret"], check=True)
    command = shell_to.command("rtmgr start --host bare")
    with opened(command, shell_to.environment, shell_to.folder) as terminal:
        terminal.until(f"Passphrase of {key}: ")
        terminal.type("secret\n")
        told = " ".join(terminal.rest().split())
    assert "manager manager of this host cannot link bare: " in told
    assert f"{key} has a passphrase and no agent holds it: ssh-add {key}" in told
    assert "Passphrase of" not in told
    subprocess.run([*change, "-P", "secret", "-N", ""], check=True)
    assert shell_to.ok("rtmgr start --host bare") == "bare: linked, manager ran already\n"
    shell_to.ok("rtmgr stop --host bare")


def test_a_manager_of_another_build_runs_on_until_it_is_to_be_replaced(
    shell_to: Shell, far: FarHost, tmp_path: Path
) -> None:
    shell_to.ok("rtmgr start --host bare")
    old, _ = _versions(far)
    shutil.copytree(wheels.cache_folder(), tmp_path / "rtkit" / "wheels")
    (own,) = (tmp_path / "rtkit" / "wheels" / "rtkit").glob("*.whl")
    with zipfile.ZipFile(own, "a") as wheel:
        wheel.writestr("rtkit/next", "")
    shell_to.environment["XDG_CACHE_HOME"] = str(tmp_path)
    told = shell_to.ok("rtmgr start --host bare")
    new, _ = _versions(far)
    assert f"manager ran already; it runs with rtkit {old} until --replace has it end" in told
    assert f"rtkit {new} is new there" in told
    ended = f"that of rtkit {old} has ended, with its components"
    told = shell_to.ok("rtmgr start --host bare --replace")
    assert told == f"bare: linked, manager replaced; {ended}\n"
    assert shell_to.ok("rtmgr start --host bare") == "bare: linked, manager ran already\n"
    shell_to.ok("rtmgr stop --host bare")


def test_a_manager_of_another_version_is_refused_before_anything_is_sent(
    shell_to: Shell, far: FarHost
) -> None:
    with connect(Host("bare", far.address, "root"), 10.0) as connection:
        made = _make(connection)
    text = f"""
        cd {_BASE}; rm -r wheels; mv versions/{made.id} versions/0.0.9
        sed -i s/0.1.0/0.0.9/ versions/0.0.9/lib/python3*/site-packages/rtkit/version.py
        ln -sfn versions/0.0.9 current
        cd; export RTKIT_HOSTNAME=bare
        {_BASE}/current/bin/python -P -m rtkit.hosts.far_manager start manager
    """
    far.run("sh", "-c", text)
    refused = shell_to.run("rtmgr start --host bare")
    assert refused.status == 1
    assert "bare: manager manager runs there with rtkit 0.0.9, as host bare; here is" in refused.err
    assert far.run("ls", _BASE).split() == ["current", "lock", "turn", "versions"]
    told = shell_to.ok("rtmgr start --host bare --replace")
    assert "manager replaced; that of rtkit 0.0.9 has ended, with its components" in told
    assert "is new there" in told
    shell_to.ok("rtmgr stop --host bare")


def test_a_link_that_leads_to_another_manager_there_is_told(shell_to: Shell) -> None:
    shell_to.ok("rtmgr start --host bare")
    for name, before in (("m2", "manager"), ("manager", "m2")):
        told = shell_to.ok(f"rtmgr start {name} --host bare")
        assert told.startswith(f"bare: linked, {name} ")
        assert told.endswith(f"; the link to {before} there has ended\n")
        assert shell_to.ok("rtls /bare") == f"{name}.mgr/\n"
    assert shell_to.ok("rtmgr stop m2 --host bare") == "bare: m2 ended\n"
    assert shell_to.ok("rtls /bare") == "manager.mgr/\n"
    assert shell_to.ok("rtmgr stop --host bare") == "bare: manager ended\n"
    assert "not linked" in shell_to.ok("rthost list")


def test_two_commands_at_once_make_one_host_ready_one_after_the_other(
    shell_to: Shell, far: FarHost
) -> None:
    both = [shell_to.open("rtmgr start --host bare") for _ in range(2)]
    told = [each.communicate(timeout=60.0) for each in both]
    assert [each.returncode for each in both] == [0, 0], told
    assert len([out for out, _ in told if "is new there" in out]) == 1
    shell_to.ok("rtmgr stop --host bare")


def test_a_manager_is_stopped_with_all_kept_for_its_next_start(shell_to: Shell) -> None:
    shell_to.ok("rtmgr start --host bare")
    shell_to.ok("rtmgr -c ConsoleIn /bare/manager.mgr")
    shell_to.ok("rtmgr stop --host bare --keep")
    shell_to.ok("rtmgr start --host bare")
    assert "ConsoleIn0.rtc" in shell_to.ok("rtls /bare")
    shell_to.ok("rtmgr stop --host bare")


def test_a_host_that_is_lost_is_let_go_at_once(shell_to: Shell, far: FarHost) -> None:
    shell_to.ok("rtmgr start --host bare")
    far.link("down")
    told = shell_to.run("rtmgr stop --host bare --timeout 1")
    assert told.status == 1
    assert "bare" in told.err
    assert "the link to it has ended; its manager may still run" in told.err
    assert not [*(shell_to.folder / "run").glob("bare.*")]
    far.link("up")
    assert shell_to.ok("rtmgr stop --host bare") == "bare: manager ended\n"
    assert shell_to.ok("rtmgr stop --host bare") == "bare: manager did not run\n"


def test_a_bare_host_runs_no_manager(shell_to: Shell) -> None:
    assert shell_to.ok("rtmgr stop --host bare") == "bare: manager did not run\n"


def test_an_extra_that_a_component_lacks_there_is_told_and_brought(
    shell_to: Shell, far: FarHost
) -> None:
    shell_to.ok("rtmgr start --host bare")
    lacking = shell_to.run("rtmgr /bare/manager.mgr -c 'HomeWorld?instance_name=world'")
    assert lacking.status == 1
    told = "rthost add --force bare ADDRESS --extra sim; rtmgr start --replace --host bare"
    assert f"No module named 'numpy': where this host was started: {told}" in lacking.err
    shell_to.ok(f"rthost add --force bare root@{far.address} --extra sim")
    replaced = shell_to.run("rtmgr start --replace --host bare", timeout_s=60.0)
    assert replaced.out.startswith("bare: linked, manager replaced"), replaced.err
    shell_to.ok("rtmgr /bare/manager.mgr -c 'HomeWorld?instance_name=world'")
    shell_to.ok("rtact /bare/world.rtc")
    shell_to.ok("rtmgr stop --host bare")


class _Index(BaseHTTPRequestHandler):
    """Simple index of the wheels for the host, with links as an index that is proxied has them."""

    files: dict[str, Path]
    project = ""

    def do_GET(self) -> None:
        *_, folder, name = self.path.partition("?")[0].split("/")
        if name and name in self.files:
            self._answer(self._wheel(name))
        elif wheels := [each for each in self.files if not name and self._is_of(each, folder)]:
            link = '<a class="x" href = "../../files/{0}?a=1&amp;b=2#sha256=0">{0}</a>'
            self._answer("".join(map(link.format, ["other-1.0.whl", *wheels])).encode())
        else:
            self.send_error(404, "Not \033[31mFound")

    def _is_of(self, wheel: str, project: str) -> bool:
        return wheel.split("-")[0].replace("_", "-").lower() == project

    def _wheel(self, name: str) -> bytes:
        data = self.files[name].read_bytes()
        return b"#" + data[1:] if name.startswith("click-") else data

    def _answer(self, data: bytes) -> None:
        self.send_response(200)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *words: object) -> None:
        """Say nothing."""


@contextmanager
def _index(address: str, files: dict[str, Path]) -> Iterator[str]:
    server = ThreadingHTTPServer((address, 0), type("Index", (_Index,), {"files": files}))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://{address}:{server.server_port}/simple"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def test_a_host_fetches_from_its_index_what_is_right_there_and_is_sent_the_rest(
    shell_to: Shell, far: FarHost
) -> None:
    with connect(Host("bare", far.address, "root"), 10.0) as connection:
        chosen = wheels.wheels_for(far_side.look(connection).kind)
    files = {name: Path(path) for name, path in chosen.files.items()}
    (lacking,) = (each for each in files if each.startswith("tomlkit-"))
    sent = sum(p.stat().st_size for n, p in files.items() if n.startswith(("rtkit-", "click-")))
    sent += files.pop(lacking).stat().st_size
    fetched = sum(path.stat().st_size for path in map(Path, chosen.files.values())) - sent
    with _index(far.near, files) as index:
        shell_to.ok(f"rthost add --force bare root@{far.address} --index {index}/")
        told = shell_to.ok("rtmgr start --host bare")
    made = f"rtkit {chosen.id} is new there, {sent / 1e6:.1f} MB sent, {fetched / 1e6:.1f} MB"
    assert f"{made} fetched from {index}/; not fetched there: click: it has other bytes" in told
    assert "tomlkit: the index answers 404 Not \\x1b[31mFound" in told
    assert _versions(far) == (chosen.id, [chosen.id])
    shell_to.ok("rtmgr stop --host bare")


@pytest.mark.parametrize("is_there", [True, False])
def test_an_index_that_does_not_answer_is_asked_once_and_all_is_sent(
    far: FarHost, is_there: bool
) -> None:
    with socket.create_server((far.near, 0)) as silent:  # which accepts nobody
        index = f"http://{far.near}:{silent.getsockname()[1]}/simple"
        if not is_there:
            silent.close()
        with connect(replace(Host("bare", far.address, "root"), index=index), 10.0) as connection:
            done = _make(connection)
    assert (done.is_new, done.fetched_bytes) == (True, 0)
    why = "timed out" if is_there else "[Errno 111] Connection refused"
    assert done.unfetched.startswith("bcrypt, cffi, click and ")
    assert done.unfetched.endswith(f" more: no answer of the index: {why}")
    assert _versions(far) == (done.id, [done.id])
