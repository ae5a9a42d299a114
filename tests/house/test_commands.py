"""One table of commands: files, console scripts, manual pages; and what a listing may import."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import make_commands
import pytest

from rtkit.cli.completion.argument_types import KINDS
from rtkit.cli.help.topics import STATUSES
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import Main
from rtkit.cli.shared.commands import COMMANDS, TABLE, load
from rtkit.deployment import extension
from rtkit.deployment.known_keys import OF_COMPONENTS, OF_PORTS, OF_SYSTEMS

ROOT = Path(__file__).parents[2]
MAX_LINES = 500
LONGEST_SUMMARY = 80
DOCUMENTS = {"rtcryo", "rtprofile show"}
"""Commands with --json for a whole document, as docs/profiles.md tells of it."""
FORBIDDEN_ON_THE_WAY = (
    "asyncio",
    "concurrent.futures",
    "dataclasses",
    "http",
    "importlib.metadata",
    "logging",
    "lxml",
    "paramiko",
    "rich",
    "rtkit.component",
    "rtkit.deployment.actions",
    "rtkit.deployment.facts",
    "rtkit.manager",
    "rtkit.planner",
    "rtkit.profile",
    "rtkit.rtc.serde",
    "rtkit.rtc.profiles",
    "rtkit.settings.layer_file",
    "shutil",
    "signal",
    "socket",
    "ssl",
    "subprocess",
    "tempfile",
    "xml",
    "xmlschema",
    "yaml",
    "zenoh",
)


def test_what_is_made_of_the_commands_is_up_to_date() -> None:
    """Table, console scripts, rows of pages; `test_man` holds the manual pages."""
    for file, text in make_commands.written().items():
        assert file.read_text(encoding="utf-8") == text, "stale, write it anew with: make commands"


def test_a_new_command_gets_its_rows_of_the_pages(monkeypatch: pytest.MonkeyPatch) -> None:
    known = make_commands.commands()
    module, main = known["rtpwd"]
    new = main._replace(name="rtfresh", json=("new-kind", "other-kind", "entry"))
    monkeypatch.setattr(make_commands, "commands", lambda: {**known, "rtfresh": (module, new)})
    pages = {
        make_commands.COMMANDS_PAGE: {"| `rtfresh` | print the working directory in the tree |"},
        make_commands.JSON_PAGE: {
            "| `new-kind` | `rtfresh` |",
            "| `other-kind` | `rtfresh` |",
            "| `entry` | `rtfresh`, `rtls`, `rtfind`: an entry of the tree |",
        },
    }
    texts = make_commands.written()
    for page, rows in pages.items():
        before = page.read_text(encoding="utf-8").splitlines()
        assert set(texts[page].splitlines()) - set(before) == rows
        assert "|\n\n" in texts[page].partition("`rtfresh`")[2], "within the table"


def test_the_page_of_commands_lists_each_once() -> None:
    text = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    rows = text.partition("\n## ")[0].splitlines()
    cells = [row.split(" | ")[0].removeprefix("| ") for row in rows if row.startswith("| `rt")]
    listed = [name.strip("`") for cell in cells for name in cell.split()]
    assert sorted(listed) == sorted(COMMANDS.values())


@pytest.mark.parametrize("name", TABLE)
def test_a_command_declares_itself(name: str) -> None:
    main = load(name)
    word = name.rpartition(" ")[2]
    assert isinstance(main, Main)
    assert (main.name, main.command.name) == (word, word)
    assert 10 < len(TABLE[name][1]) <= LONGEST_SUMMARY, "the first sentence of the help"
    assert len(main.examples) > 1, "-h ends with two"
    assert all(line.startswith(name) or " | " in line for line, _ in main.examples)
    options = {text: each for each in main.command.params for text in each.opts}
    assert main.values.keys() <= options.keys()
    kinds = {*(main.arguments or ()), *main.values.values()}
    assert kinds <= KINDS, "rtkit.cli.completion.argument_types knows the types of arguments"
    assert main.statuses.keys() <= STATUSES.keys()
    assert ("--json" in options) == bool(main.json) or name in DOCUMENTS
    text = (ROOT / "docs" / "json.md").read_text(encoding="utf-8")
    for kind in main.json:
        assert (ROOT / "schemas" / "json" / f"{kind}.1.schema.json").is_file()
        row = next((row for row in text.splitlines() if f"`{kind}`" in row), "")
        assert f"`{name}" in row or f"`{word}" in row, f"docs/json.md: {kind} of {name}"


def test_a_command_s_help_ends_with_two_examples(capsys: pytest.CaptureFixture[str]) -> None:
    for name in TABLE:
        first, *word = name.split()
        assert load(first)([*word, "-h"]) == 0
        told = " ".join(capsys.readouterr().out.partition("\n\nExamples:\n")[2].split())
        for line, does in load(name).examples[:2]:
            assert " ".join(line.split()) in told, name
            assert " ".join(does.split()) in told, name


EACH_LOADED = """
import os, sys
from rtkit.cli.shared.commands import TABLE, load
load("rtpwd")  # what all have in common is loaded once
for name in TABLE:
    if not os.fork():
        load(name)
        print(name, *({heavy!r} & sys.modules.keys()), sep=",", flush=True)
        os._exit(0)
    os.wait()
"""


def test_a_command_is_loaded_without_anything_heavy() -> None:
    script = EACH_LOADED.format(heavy=set(FORBIDDEN_ON_THE_WAY))
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    found = {
        name: set(heavy) for name, *heavy in (row.split(",") for row in done.stdout.split("\n"))
    }
    assert {name for name in found if name} == set(TABLE)
    too_much = {name: heavy - HEAVY_WHEN_LOADED.get(name, set()) for name, heavy in found.items()}
    assert {name: heavy for name, heavy in too_much.items() if heavy} == {}, "import it in main"


FACTS = {"rtkit.deployment.facts", "rtkit.rtc.profiles"}
HEAVY_WHEN_LOADED = {
    "rtapply": {"dataclasses"},
    "rtconfig": {"rtkit.settings.layer_file"},
    "rtplan": {"dataclasses"},
    "rtprofile convert": {"rtkit.profile"},
    "rtprofile resolve": {"rtkit.profile"},
    "rtprofile from": {"rtkit.profile"},
    "rtstate": {"dataclasses"},
    "rttop": FACTS,
    "rtwatch": FACTS,
}
SHOWN = {*FACTS, "rtkit.rtc.serde"}
SYSTEM = {*FACTS, "lxml", "rtkit.profile"}
PLANNED = {*SYSTEM, "rtkit.deployment.actions", "rtkit.planner", "dataclasses", "rtkit.component"}
FOR_REPAIRS_AND_CHANGES = (
    "difflib",
    "locale",
    "rtkit.cli.shared.progress",
    "rtkit.api.step_times",
    "rtkit.deployment.listing",
    "rtkit.deployment.planning",
    "rtkit.link.wakeup",
    "rtkit.profile.normalise",
    "rtkit.profile.parameters",
    "rtkit.profile.references",
    "rtkit.report",
    "rtkit.deployment.runner",
    "rtkit.tree.resurrect",
    "rtkit.tree.view",
)
READERS: dict[str, tuple[set[str], tuple[str, ...]]] = {
    "rtls /localhost": (set(), ("difflib", "locale", "rtkit.fast_dataclass")),
    "rtls -l /localhost": (set(), ()),
    "rtcat /localhost/A.rtc": (SHOWN, ("difflib", "locale", "rtkit.deployment.drift")),
    "rtconf /localhost/A.rtc list": (SHOWN, ("difflib", "locale")),
    "rtfind / -t c": (set(), ()),
    "rtcheck --state Inactive FILE": (SYSTEM, FOR_REPAIRS_AND_CHANGES),
    "rtresurrect --dry-run FILE": (
        {*SYSTEM, "rtkit.deployment.actions"},
        (*FOR_REPAIRS_AND_CHANGES, "difflib", "rtkit.deployment.planning.model"),
    ),
    "rtstart --dry-run FILE": ({*SYSTEM, "rtkit.deployment.actions"}, FOR_REPAIRS_AND_CHANGES),
    "rtstop --dry-run FILE": ({*SYSTEM, "rtkit.deployment.actions"}, FOR_REPAIRS_AND_CHANGES),
    "rtteardown --dry-run FILE": ({*SYSTEM, "rtkit.deployment.actions"}, FOR_REPAIRS_AND_CHANGES),
    "rtplan FILE": (PLANNED, ("http.client", "packaging", "rtkit.hosts.inventory")),
    "rtapply --dry-run FILE": (PLANNED, ("http.client", "packaging", "rtkit.hosts.inventory")),
    "rtcryo --all": (
        {*FACTS, "rtkit.profile"},
        ("difflib", "locale", "rtkit.report", "rtkit.tree.view"),
    ),
}
"""What commands that only read need, of what is forbidden on the way, and what else they leave."""

PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts"
  xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  rts:version="0.2" rts:updateDate="2024-01-31T12:00:00+09:00"
  rts:creationDate="2024-01-31T12:00:00+09:00" rts:id="RTSystem:me:one:1">
  <rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:me:example:T:1"
    rts:pathUri="localhost/A.rtc" rts:instanceName="A" rts:isRequired="true">
    <rtsExt:Properties rtsExt:name="implementation_id" rtsExt:value="T"/>
  </rts:Components>
</rts:RtsProfile>
"""
WITH_ONE = """
import sys
from rtkit.cli.shared.commands import load
import rtkit.tree.client
class Tree:
    host, manager, timeout_s = 'box', 'm', 10.0
    def listing(self):
        from rtkit.deployment.listing import Listing, ListingRow
        row = ('A', 'Inactive', 0, 0, 0, 0, 0, 0, 'm', '', '', False, ('localhost/A.rtc',))
        return Listing('box', 'm', 1, (), (ListingRow(*row),))
    def listing_at(self, paths):
        return self.listing()
    def snapshot(self):
        from rtkit.deployment.facts import ComponentFacts, Snapshot
        from rtkit.rtc.enums import ExecutionKind
        from rtkit.rtc.profiles import ExecutionContextProfile, TypeProfile
        context = ExecutionContextProfile('0', ExecutionKind.PERIODIC, 1.0, 'A')
        kind = TypeProfile('T', 'me', 'example', '1')
        facts = ComponentFacts('A', kind, 'm', contexts=(context,), names=('localhost/A.rtc',),
            code='00000000 /no/A.py')
        return Snapshot('box', 'm', 1, '', components=(facts,))
    def part(self, instances):
        return self.snapshot()
status = load({name!r})({arguments!r}, tree=Tree())
print(status, [name for name in {heavy!r} if name in sys.modules], file=sys.stderr)
"""


@pytest.mark.parametrize("line", READERS)
def test_who_only_reads_imports_nothing_heavy(line: str, tmp_path: Path) -> None:
    file = tmp_path / "system.xml"
    file.write_text(PROFILE, encoding="utf-8")
    needed, left = READERS[line]
    name, *words = line.split()
    arguments = [str(file) if word == "FILE" else word for word in words]
    heavy = [each for each in (*FORBIDDEN_ON_THE_WAY, *left) if each not in needed]
    script = WITH_ONE.format(name=name, arguments=arguments, heavy=heavy)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.stderr == "0 []\n"


OF_A_SERVED_VALUE = """
import os, sys
from rtkit.cli.shared.commands import load
ready, served = os.pipe()
asking = os.fork()
if not asking:
    os.read(ready, 1)
    status = load({name!r})({arguments!r})
    left = ("dataclasses", "rtkit.property.live_values", "rtkit.property.types")
    print(status, [name for name in left if name in sys.modules], file=sys.stderr, flush=True)
    os._exit(0)
from rtkit.property.service import Service
from rtkit.wires.serve import serve
service = Service()
service.add("level", 0.5, "number")
with serve(service, "lamp", is_on_zenoh=False):
    os.write(served, b"x")
    os.waitpid(asking, 0)
"""


@pytest.mark.parametrize("line", ["rtget lamp.level", "rtset lamp.level 0.7"])
def test_who_asks_a_service_imports_nothing_of_the_owner_s_side(line: str) -> None:
    name, *arguments = line.split()
    with TemporaryDirectory(prefix="rtkit-") as folder:
        done = subprocess.run(
            [sys.executable, "-c", OF_A_SERVED_VALUE.format(name=name, arguments=arguments)],
            capture_output=True, text=True, check=False, timeout=60.0,
            env={**os.environ, "RTKIT_RUNTIME_DIR": f"{folder}/run"},
        )  # fmt: skip
    assert done.stderr == "0 []\n"


def test_who_only_stops_a_manager_imports_nothing_that_starts_or_commands_one() -> None:
    script = (
        "import sys\n"
        "from rtkit.cli.managers.rtmgr import main\n"
        "assert main(['stop', 'no-such-manager']) == 1\n"
        "names = ('rtkit.settings.properties', 'rtkit.cli.managers.steps', 'rtkit.rtc.profiles')\n"
        "print([name for name in names if name in sys.modules], file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.stderr.splitlines()[-1] == "[]"


def test_the_verdict_on_a_valid_profile_imports_nothing_heavy() -> None:
    needed = {"lxml", "rtkit.profile", "concurrent.futures", "yaml"}
    script = (
        "import sys\n"
        "from rtkit.cli.profiles.rtprofile import main\n"
        f"assert main(['validate', {str(ROOT / 'profiles' / 'Motor.xml')!r}]) == 0\n"
        f"names = {(*FORBIDDEN_ON_THE_WAY, 'elementpath', 'difflib', 'urllib')}\n"
        f"found = [name for name in names if name in sys.modules and name not in {needed}]\n"
        "print(found, file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.stderr == "[]\n"
    assert done.stdout.endswith("Motor.xml: valid (RTC profile)\n")


FOR_WHO_MAKES_COMPONENTS = (
    "base64",
    "importlib.util",
    "logging",
    "mmap",
    "rtkit.component.collisions",
    "rtkit.component.composite",
    "rtkit.component.factory",
    "rtkit.component.fsm",
    "rtkit.component.standin",
    "rtkit.deployment.metrics",
    "rtkit.deployment.supervision",
    "rtkit.manager.core.events",
    "rtkit.container.component_factory",
    "rtkit.container.process_settings",
    "rtkit.logs.logs",
    "rtkit.modules",
    "rtkit.settings",
    "signal",
    "traceback",
)
VISIT = f"""
import queue, sys, threading
import rtkit.cli.data.rtprint, rtkit.cli.data.printing
import rtkit.component.values.fields, rtkit.component.values.value_text
import rtkit.container.attached_process
from rtkit.component import TimedLong
from rtkit.link.local.streams import LocalStreams
from rtkit.container.port_wiring import PortWiring
from rtkit.container.container import ComponentContainer
from rtkit.probe.probe import Tool
from rtkit.probe.tap import Tap
told = queue.SimpleQueue()
wiring = PortWiring("box", LocalStreams("none"))
holder = ComponentContainer(told.put, wiring, component_factory=None)
thread = threading.Thread(target=holder.run)
thread.start()
holder.post(lambda: holder.hold(Tool("Tool0", [Tap("in", {{}})], 0.0)))
holder.report_all(told.put)
where = {{"instance": "Tool0", "context": "0", "call": 1}}
holder.put({{"op": "change_state", "transition": "activate", **where}})
while told.get(timeout=30.0).get("reply") != 1: pass
holder.put({{"op": "delete", "instance": "Tool0"}})
while told.get(timeout=30.0).get("gone") != "Tool0": pass
holder.close()
thread.join()
print([name for name in {FOR_WHO_MAKES_COMPONENTS!r} if name in sys.modules], file=sys.stderr)
"""


def test_a_guest_imports_nothing_that_makes_components() -> None:
    done = subprocess.run(
        [sys.executable, "-c", VISIT], capture_output=True, text=True, check=False
    )
    assert done.stderr == "[]\n"


LATE = """
import ast, sys
from importlib import import_module
from pathlib import Path
from rtkit.manager.slaves import zygote
for name in zygote.AHEAD:
    import_module(name)
late = set()
for file in Path(zygote.__file__).parents[2].glob("container/*.py"):
    for function in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(function, ast.FunctionDef):
            late |= {n.module for n in ast.walk(function) if isinstance(n, ast.ImportFrom)}
between_hosts = {"rtkit.link.routed_streams"}  # few need that library
print(len(late) > 3, sorted(late - set(sys.modules) - between_hosts))
"""


def test_what_holders_import_late_is_in_every_slave_from_its_beginning() -> None:
    done = subprocess.run([sys.executable, "-c", LATE], capture_output=True, text=True, check=True)
    assert done.stdout == "True []\n"


def test_no_file_is_longer_than_a_reader_can_hold() -> None:
    long = {
        str(file.relative_to(ROOT)): count
        for folder in ("rtkit", "examples", "bench", "campaign")
        for file in (ROOT / folder).rglob("*.py")
        if (count := len(file.read_text(encoding="utf-8").splitlines())) > MAX_LINES
    }
    assert long == {}


def test_nothing_tells_where_it_was_written() -> None:
    words = ("/" + "work/", "farm" + "-", "." + "library")
    folders = ("rtkit", "tests", "examples", "bench", "campaign", "docs", "man", "schemas")
    files = [file for folder in folders for file in (ROOT / folder).rglob("*")]
    found = [
        (str(file), word)
        for file in files
        if file.is_file() and file.suffix in (".py", ".md", ".toml", ".txt", ".xsd", ".1")
        for word in words
        if word in file.read_text(encoding="utf-8")
    ]
    assert found == []


def _commands() -> Iterator[tuple[str, click.Command]]:
    """Yield each command, and each word of those that have words, as it is typed."""
    for name in TABLE:
        yield name, load(name).command


def test_each_property_of_profiles_belongs_to_somebody() -> None:
    names = {
        name: text
        for name, text in vars(extension).items()
        if name.isupper() and isinstance(text, str)
    }
    mine = {text for text in names.values() if text.startswith("rtkit.")}
    kept = {extension.STATED_ID, extension.STATED_KIND, extension.UNSTATED}
    told = {*OF_SYSTEMS, *OF_COMPONENTS, *OF_PORTS}
    assert mine - kept == told - {f"{extension.STAND_IN}."}


REQUESTS = {"rtget", "rtset", "rtlisten", "rtserve", "rtbuild"}
"""What these are given goes to its owner, who refuses what he does not know."""
CHECKS = {"rtprofile check", "rtprofile validate", "rtconf", "rtdoctor"}


def test_every_command_that_takes_keys_has_the_one_switch_for_warnings() -> None:
    lacking = []
    for name, each in _commands():
        options = {text: option for option in each.params for text in option.opts}
        told = {option.metavar or "" for option in each.params}
        takes_keys = any("KEY" in text or text == "OPTIONS" for text in told) or "--map" in options
        strict = options.get("--strict")
        if strict is None:
            lacking += [name] if (takes_keys and name not in REQUESTS) or name in CHECKS else []
            continue
        app = App("x")
        with each.make_context("x", ["--strict"], obj=app, resilient_parsing=True) as context:
            strict.process_value(context, True)
            assert app.is_strict, f"{name} has a switch of its own"
    assert not lacking
