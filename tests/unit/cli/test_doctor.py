"""What ``rtdoctor`` makes of what it sees; tests/system has it look at broken set-ups."""

from __future__ import annotations

import errno
import os
import re
import socket
from datetime import timedelta
from pathlib import Path

import jsonrecords
import pytest

from rtkit.cli.managers.doctor import (
    ERROR,
    NOTE,
    OK,
    WARNING,
    Diagnosis,
    data_link,
    folders,
    installation,
    keys,
    live,
)
from rtkit.cli.managers.rtdoctor import main
from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
from rtkit.deployment.listing import Listing, ListingRow
from rtkit.errors import Unreachable
from rtkit.fast_dataclass import replace
from rtkit.keys import authority
from rtkit.link import host_links
from rtkit.link.host_links import HostLink
from rtkit.rtc.profiles import ModuleProfile, TypeProfile
from rtkit.version import __version__


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folders of this test alone, and none of the variables of who runs it."""
    for name in [each for each in os.environ if each.startswith("RTKIT_")]:
        monkeypatch.delenv(name)
    for name in ("RUNTIME", "STATE"):
        folder = tmp_path / name
        folder.mkdir(mode=0o700)
        monkeypatch.setenv(f"RTKIT_{name}_DIR", str(folder))
    return tmp_path


def bad(found: list[Diagnosis]) -> list[tuple[str, str]]:
    return [(each.severity, each.cure) for each in found if each.severity != OK]


@pytest.mark.parametrize("version", ["1.10.0", "1.12.3"])
def test_a_fitting_transport(version: str) -> None:
    assert installation.transport(version) is None


def test_the_version_of_what_is_installed(tmp_path: Path) -> None:
    from importlib.metadata import version

    (tmp_path / "Some_thing-1.2.3.dist-info").mkdir()
    (tmp_path / "some_thing_else-9.dist-info").mkdir()
    folders = [str(tmp_path / "none"), str(tmp_path)]
    assert installation.version_of("some_thing", folders) == "1.2.3"
    assert installation.version_of("eclipse_zenoh", ()) == version("eclipse-zenoh")
    assert installation.version_of("no_such_thing", folders) is None


@pytest.mark.parametrize("version", ["1.9.9", "2.0.0", "nightly"])
def test_an_odd_transport(version: str) -> None:
    found = installation.transport(version)
    assert found is not None
    assert (found.severity, found.cure.startswith("python -m pip install")) == (ERROR, True)


def test_limits() -> None:
    assert installation.files(1024, 4096).severity == OK
    assert installation.files(-1, -1).severity == OK
    few = installation.files(256, 512)
    assert (few.severity, few.cure) == (WARNING, "ulimit -n 512")


def test_a_large_value_is_sent_and_nothing_is_left(place: Path) -> None:
    (found,) = data_link.data_link()
    assert (found.check, found.severity) == ("links", OK), found
    assert not list((place / "RUNTIME").iterdir())


def test_a_connection_that_cannot_be_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise Unreachable("cannot listen")

    monkeypatch.setattr("rtkit.link.unix.listen", refuse)
    (found,) = data_link.data_link()
    assert (found.check, found.severity) == ("links", ERROR)
    assert "cannot listen" in found.text


def test_a_large_value_that_has_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", refuse)
    (found,) = data_link.data_link()
    assert (found.check, found.severity) == ("links", ERROR)
    assert "No space left on device" in found.text


def test_a_clock_before_the_installation() -> None:
    assert [each.severity for each in installation.clock(5.0, 10.0)] == [ERROR]
    assert [each.severity for each in installation.clock(10.0, 5.0)] == [OK]


def test_every_variable_that_rtkit_reads_is_known() -> None:
    package = Path(installation.__file__).parents[3]
    named = {
        name
        for file in package.rglob("*.py")
        for name in re.findall(r'"(RTKIT_[A-Z_]+)"', file.read_text(encoding="utf-8"))
    }
    assert named
    assert sorted(named - set(installation._VARIABLES)) == []


def test_variables(tmp_path: Path) -> None:
    assert bad(list(installation.variables({"RTKIT_MANAGER": "a", "RTKITTY": "x"}))) == []
    (near,) = installation.variables({"RTKIT_MANAGR": "a"})
    assert (near.severity, near.cure) == (WARNING, "unset RTKIT_MANAGR")
    gone = str(tmp_path / "gone")
    (folder,) = installation.variables({"RTKIT_MODULE_PATH": f"{tmp_path}:{gone}"})
    assert (folder.severity, gone in folder.text) == (WARNING, True)
    (file,) = installation.variables({"RTC_MANAGER_CONFIG": gone})
    assert file.severity == ERROR


def test_the_shell_of_a_person(tmp_path: Path) -> None:
    told = installation.shell({"SHELL": "/bin/bash"}, str(tmp_path))
    assert (told.severity, told.cure) == (NOTE, 'add to it: eval "$(rtkit shell-init bash)"')
    (tmp_path / ".bashrc").write_text('eval "$(rtkit shell-init bash)"\n')
    assert installation.shell({"SHELL": "/bin/bash"}, str(tmp_path)).severity == OK


def test_folders_that_are_open_or_cannot_be_made(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert bad(list(folders.folders())) == []
    (place / "RUNTIME").chmod(0o755)
    assert bad(list(folders.folders())) == [(ERROR, f"chmod 700 {place / 'RUNTIME'}")]
    (place / "file").write_text("")
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(place / "file" / "run"))
    assert bad(list(folders.folders())) == [(ERROR, "choose another one with RTKIT_RUNTIME_DIR")]
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", f"/tmp/{'x' * 120}")
    assert [severity for severity, _ in bad(list(folders.folders()))] == [ERROR]


def test_a_secret_that_others_read(place: Path) -> None:
    secret = place / "STATE" / "door.secret"
    secret.write_text("a:b\n")
    secret.chmod(0o644)
    ((severity, cure),) = bad(list(folders.folders()))
    assert (severity, cure.startswith(f"rm {secret}")) == (ERROR, True)


def test_what_killed_processes_left(place: Path) -> None:
    assert bad(list(folders.remains())) == []
    run = place / "RUNTIME"
    (run / "old.sock").touch()
    (run / "gone.4194303.data").touch()
    found = list(folders.remains())
    assert [each.subject for each in found] == ["old", "gone"]
    assert {each.severity for each in found} == {ERROR}
    for pid, kind in ((os.getpid(), "beats"), (os.getpid(), "data"), (os.getppid(), "zygote")):
        (run / f"old.{pid}.{kind}").touch()
    assert "live on: 1" in next(folders.remains()).text


def test_dumps_of_faults_are_named_with_what_shows_them(place: Path) -> None:
    assert bad(list(folders.stores())) == []
    state = place / "STATE"
    for name in ("m.fault-1.dump", "m.fault-2.dump", "a b.fault-1.dump", "m.dump", "m.log"):
        (state / name).touch()
    told = [(each.severity, each.text, each.cure) for each in folders.stores()]
    assert told == [
        (
            WARNING,
            f"a fault in the work of manager 'a b' was dumped: {state}/a b.fault-1.dump",
            f"rtmgr replay '{state}/a b.fault-1.dump' shows it; report it, then remove the file",
        ),
        *(
            (
                WARNING,
                f"a fault in the work of manager 'm' was dumped: {state}/m.fault-{number}.dump",
                f"rtmgr replay {state}/m.fault-{number}.dump shows it; report it, then remove the"
                " file",
            )
            for number in (1, 2)
        ),
    ]


FACTS = Snapshot("box", "m", 1, __version__)


def listing(*rows: ListingRow, slaves: tuple[tuple[str, str, str], ...] = ()) -> Listing:
    return Listing("box", "m", 1, slaves, rows)


def row(name: str, state: str = "Inactive", **more: str) -> ListingRow:
    plain = ListingRow(
        name, state, 0, 0, 0, 0, 0, 0, "m", "", "", False, (f"localhost/{name}.rtc",)
    )
    return plain._replace(**more)  # type: ignore[arg-type]


def test_what_a_manager_says() -> None:
    processes = (ProcessFacts("s", True, 7, "stopped"), ProcessFacts("t", True, 8, "lost"))
    facts = Snapshot("box", "m", 1, __version__, processes)
    slaves = (("s", "stopped", ""), ("t", "lost", "signal 9"), ("u", "up", "step sleeps"))
    rows = (row("A", zombie="signal 9"), row("B", "Error", cause="x"), row("C", trouble="stopped"))
    assert bad(list(live.judge("m", listing(*rows, slaves=slaves), facts))) == [
        (ERROR, "kill -CONT 7"),
        (ERROR, "rtdel -z takes its entries away, rtresurrect makes them again"),
        (WARNING, "rtexit --force /localhost/m.mgr/u.mgr"),
        (ERROR, "rtdel -z /localhost/A.rtc, or rtresurrect makes it again"),
        (WARNING, "rtreset /localhost/B.rtc"),
        (WARNING, "rtexit --force /localhost/C.rtc if it does not come back"),
    ]
    assert bad(list(live.judge("m", listing(row("A")), facts))) == []


def test_one_in_a_debugger_is_no_reason_to_end_it() -> None:
    found = list(live.judge("m", listing(row("A", trouble="in a debugger since 12:00")), FACTS))
    assert [(each.severity, each.cure) for each in found[1:]] == [(NOTE, "")]


def test_old_code_is_told(tmp_path: Path) -> None:
    file = tmp_path / "A.py"
    file.write_text("edited since")
    process = ProcessFacts("A_7", False, 7, "up", "", True)
    parts = [
        ComponentFacts(name, TypeProfile("T"), place, code=f"00000000 {file}")
        for name, place in (("A", "A_7"), ("B", "s"))
    ]
    facts = replace(FACTS, processes=(process,), components=tuple(parts))
    assert [each.cure for each in live.old_code(facts)] == [
        "start it again",
        "rtapply --replace PROFILE makes it again with the present code",
    ]
    file.unlink()
    assert list(live.old_code(facts)) == []


def test_what_old_components_miss_is_told(tmp_path: Path) -> None:
    file = tmp_path / "A.py"
    file.write_text("import OpenRTM_aist\nport = OpenRTM_aist.SdoServiceAdmin()\n")
    component = ComponentFacts("A", TypeProfile("T"), "s", code=f"00000000 {file}")
    facts = replace(FACTS, components=(component,))
    (found,) = live.absences(facts)
    assert found.text.startswith(f"{file}:2 uses OpenRTM_aist.SdoServiceAdmin of OpenRTM-aist")
    file.write_text("no Python any more, OpenRTM_aist")
    (found,) = live.absences(facts)
    assert (found.severity, found.text) == (WARNING, f"{file}:1: invalid syntax")


def test_what_modules_without_a_component_miss_is_told(tmp_path: Path) -> None:
    file = tmp_path / "A.py"
    facts = replace(FACTS, modules=(ModuleProfile("A.py", "AInit", (), str(file)),))
    told = []
    for text in ("import OpenRTM_aist\nOpenRTM_aist.SdoServiceAdmin()\n",
                 "import OpenRTM_aist\nprint 1\n", "native = 1\n"):  # fmt: skip
        file.write_text(text)
        told += [each.text for each in live.absences(facts)]
    file.unlink()
    told += [each.text for each in live.absences(facts)]
    assert told == [
        f"{file}:2 uses OpenRTM_aist.SdoServiceAdmin of OpenRTM-aist, which rtkit does not have",
        f"{file}:2 is Python 2 (print as a statement): rtkit openrtm migrate {file} converts it",
        f"module {file} cannot be read any more: No such file or directory",
    ]


def test_a_manager_of_another_version() -> None:
    ((severity, cure),) = bad(list(live.judge("m", listing(), Snapshot("box", "m", 1, "0.0.1"))))
    assert (severity, cure.startswith("rtmgr restart m")) == (ERROR, True)


@pytest.mark.parametrize(
    ("address", "properties", "asked", "wanted"),
    [
        ("localhost:2810", {}, "", OK),
        ("", {"manager.net_servant": "NO"}, "", OK),
        ("", {}, "none", OK),
        ("", {}, "", WARNING),
    ],
)
def test_doors(address: str, properties: dict[str, str], asked: str, wanted: str) -> None:
    (found,) = live.endpoint("m", address, properties, asked)
    assert found.severity == wanted


def test_a_port_that_somebody_has() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen(1)
        port = str(other.getsockname()[1])
        (_, found) = live.managers(0.1, {"RTKIT_PORT": port})
        assert (found.severity, found.subject) == (WARNING, port)
    (_, found) = live.managers(0.1, {"RTKIT_PORT": port})
    assert found.severity == OK
    assert len(list(live.managers(0.1, {"RTKIT_PORT": "none"}))) == 1


def test_the_command_without_a_manager(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTKIT_PORT", "none")
    assert main(["--json"]) == 0
    records = jsonrecords.checked(capsys.readouterr().out)
    assert {jsonrecords.kind_of(record) for record in records} == {"diagnosis"}
    monkeypatch.setenv("RTKIT_MANAGER", "nobody")
    assert main([]) == 1
    assert "error: RTKIT_MANAGER names a manager that does not run: nobody\n" in (
        capsys.readouterr().out
    )
    monkeypatch.setenv("RTKIT_MANAGER", "")
    monkeypatch.setenv("RTKIT_CDW", "/")
    assert main([]) == 0
    assert main(["--strict"]) == 1
    assert main(["x"]) == 1


@pytest.fixture
def owner(place: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keys of this test alone, made with the most open of all umasks."""
    monkeypatch.setenv("RTKIT_KEYS", str(place / "keys"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(place / "config"))
    before = os.umask(0)
    try:
        authority.init("owner1")
    finally:
        os.umask(before)
    return place / "keys"


def _cures() -> list[tuple[str, str, str]]:
    return [
        (e.severity, e.text, e.cure) for e in [*keys.own_keys(), *keys.hosts()] if e.severity != OK
    ]


def test_keys_are_in_order_whatever_the_umask(owner: Path) -> None:
    assert _cures() == []
    modes = {each.stat().st_mode & 0o077 for each in owner.rglob("*")}
    assert modes == {0}


@pytest.mark.parametrize("name", ["ca.key", "own.key"])
def test_a_key_that_others_can_read_is_an_error(owner: Path, name: str) -> None:
    (owner / name).chmod(0o640)
    (found,) = _cures()
    text = f"others can read it (mode 640): {owner / name}"
    assert found == (ERROR, text, "chmod 600 if none has, else revoke")


@pytest.mark.parametrize("name", ["ca.crt", "own.crt", "revoked.crl"])
def test_who_is_trusted_is_for_nobody_else_to_write(owner: Path, name: str) -> None:
    (owner / name).chmod(0o622)
    assert [each[:2] for each in _cures()] == [
        (ERROR, f"others can write it (mode 622): {owner / name}")
    ]


def test_a_folder_of_keys_that_others_can_write_in(owner: Path) -> None:
    owner.chmod(0o777)
    assert _cures()[0] == (ERROR, f"others can write in {owner} (mode 777)", f"chmod go= {owner}")


@pytest.mark.parametrize("name", ["own.key", "own.crt", "ca.crt", "revoked.crl"])
def test_keys_that_are_missing_or_do_not_fit(owner: Path, name: str) -> None:
    content = (owner / name).read_bytes()
    (owner / name).write_bytes(content[:-60])
    assert [each[0] for each in _cures()] == [ERROR]
    (owner / name).unlink()
    assert [each[0] for each in _cures()] == [ERROR]
    (owner / name).symlink_to("/dev/zero")
    assert [each[0] for each in _cures()] == [ERROR]


def test_the_key_of_somebody_else_does_not_fit(owner: Path) -> None:
    authority.issue("anna", "viewer", [], 5, str(owner.parent / "anna"))
    (owner / "own.key").write_bytes((owner.parent / "anna/own.key").read_bytes())
    assert "cannot be used" in _cures()[0][1]


def test_times_of_a_certificate(owner: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = authority.own()
    for moment, severity in (
        (own.begins - timedelta(days=1), ERROR), (own.begins, OK), (own.ends, WARNING),
        (own.ends + timedelta(days=1), ERROR),
    ):  # fmt: skip
        assert keys.judge(own, moment).severity == severity
    authority.revoke("owner1")
    assert _cures()[0][1] == "the certificate of owner1 is revoked"


def test_a_record_and_an_inventory_that_others_can_reach(owner: Path, place: Path) -> None:
    record = place / "STATE/audit.jsonl"
    record.touch(0o600)
    assert _cures() == []
    record.chmod(0o644)
    inventory = place / "config/rtkit/hosts.toml"
    inventory.parent.mkdir(parents=True, exist_ok=True)
    inventory.write_text('[robot1]\naddress = "robot1"\n', encoding="ascii")
    inventory.chmod(0o666)
    assert [each[0] for each in _cures()] == [ERROR, ERROR]
    assert _cures()[0][1:] == (f"others can read {record} (mode 644)", f"chmod go= {record}")
    assert "may be written by everybody" in _cures()[1][1]


def test_without_keys_nobody_is_let_in(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RTKIT_KEYS", str(place / "none"))
    assert [each.text for each in keys.own_keys()] == ["no keys: nobody on another host is let in"]


@pytest.mark.parametrize(
    ("why", "cure"),
    [
        ("", ""),
        ("fa: No route to host", "rthost check fa"),
        ("fa: not running (start it with: rtmgr start --host fa)", "rtmgr start --host fa"),
        ("fa: not running (start it with: rtmgr start)", "rtmgr start --host fa"),
    ],
)
def test_the_cure_of_a_link_is_the_command_that_mends_it(
    why: str, cure: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(host_links, "hosts", lambda: ["fa"])
    monkeypatch.setattr(host_links, "read", lambda host: HostLink(host, "m", "manager", why))
    assert [each.cure for each in live.links()] == [cure]
