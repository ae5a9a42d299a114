"""Makes the pictures in docs/web of the page of ``rtkit web``, by a real system and a real browser.

Run it in the virtual environment, with chromium on the PATH: ``python tools/web_pictures.py``.
"""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

import browser  # noqa: E402 (found by the line above)

OUT = ROOT / "docs" / "web"
SYSTEM = """
rtmgr start
rtmgr -c MyServiceProvider -c MyServiceConsumer?manager_name=hands /localhost/manager.mgr
rtmgr -c SeqIn -c SeqOut?manager_name=eyes -c ConfigSample /localhost/manager.mgr
rtmgr -c Sensor -c Controller -c Motor?manager_name=hands /localhost/manager.mgr
rtcon /localhost/MyServiceProvider0.rtc:myservice /localhost/MyServiceConsumer0.rtc:myservice
rtcon /localhost/SeqOut0.rtc:Long /localhost/SeqIn0.rtc:Long
rtcon /localhost/SeqOut0.rtc:FloatSeq /localhost/SeqIn0.rtc:FloatSeq
rtcon /localhost/Sensor0.rtc:distance /localhost/Controller0.rtc:distance
rtcon /localhost/Controller0.rtc:velocity /localhost/Motor0.rtc:velocity
rtact /localhost/SeqOut0.rtc
rtact /localhost/SeqIn0.rtc
rtcon /localhost/Motor0.rtc:pose /localhost/Sensor0.rtc:pose
rtact /localhost/Sensor0.rtc
rtact /localhost/Controller0.rtc
rtact /localhost/Motor0.rtc
"""
CONFIG = "/localhost/ConfigSample0.rtc"
SEQ = "/localhost/SeqOut0.rtc"
PATROL = ROOT / "tests" / "unit" / "services" / "statemachine" / "patrol.ttl"
SIZE = (1120, 700)
OPEN = "document.querySelector('dialog[open]') !== null"


def shell(line: str) -> str:
    """Run a command line and return what it wrote."""
    done = subprocess.run(shlex.split(line), stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout


@contextmanager
def served(folder: str) -> Iterator[str]:
    """Serve the page and yield its address."""
    line = ["rtweb", "--no-browser", "--root", folder]
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.send_signal(signal.SIGINT)
            process.wait()


class Studio:
    """The page, brought into situations and taken."""

    def __init__(self, page: browser.Browser) -> None:
        self.page = page

    def go(self, fragment: str, condition: str) -> None:
        """Go to a view and wait until it is there."""
        self.page.evaluate(f"location.hash = {fragment!r}")
        self.page.wait_for(condition)

    def take(self, name: str, *, is_dark: bool = False, size: tuple[int, int] = SIZE) -> None:
        """Save the picture, when what moves has come to rest."""
        self.page.look(is_dark=is_dark)
        self.page.rest()
        file = OUT / f"{name}.png"
        self.page.picture(str(file), *size, is_dark=is_dark)
        print(f"{file.relative_to(ROOT)}: {file.stat().st_size >> 10} KiB")

    def dialog(self, key: str, condition: str, *, is_control: bool = False) -> None:
        """Open a dialog by its key."""
        self.page.key(key, is_control=is_control)
        self.page.wait_for(condition)

    def close(self) -> None:
        """Close the dialog that is open."""
        self.page.key("Escape")
        self.page.wait_for(f"!({OPEN})")


def situations(studio: Studio, files: str) -> None:
    """Take all pictures, one after the other."""
    page = studio.page
    page.wait_for("document.querySelector('.react-flow__edge text') !== null")
    studio.take("1-diagram")
    studio.go(f"#select={SEQ}", "document.querySelector('.inspector .ports') !== null")
    studio.take("2-dark", is_dark=True)
    studio.go(f"#select={CONFIG}", "document.querySelector('.inspector .slider') !== null")
    studio.take("3-configuration")
    studio.go(f"#select={SEQ}", "document.querySelector('.inspector .ports') !== null")
    studio.dialog("c", "document.querySelector('dialog .far-ports input[type=radio]') !== null")
    studio.take("4-connect")
    studio.close()
    studio.dialog("k", OPEN, is_control=True)
    page.type("dialog input", "seq")
    studio.take("5-palette")
    studio.close()
    studio.go("#view=table", "document.querySelector('.tables') !== null")
    studio.take("6-table")
    studio.go(
        "#select=/localhost/manager.mgr", "document.querySelector('.react-flow__node') !== null"
    )
    page.press("Create a component …")
    page.wait_for("document.querySelector('dialog .options input') !== null")
    studio.take("7-create")
    studio.close()
    shell(f"rtcryo --all -o {files}/robot.yaml")
    shell(f"rtconf {CONFIG} set int_param0 42")
    studio.go(f"#view=plan&of=do:{files}/robot.yaml", "document.querySelector('.deeds') !== null")
    page.press("Show the plan")
    page.wait_for("document.querySelector('.steps') !== null")
    studio.take("11-plan")
    studio.go(
        f"#view=plan&of=compare:{files}/robot.yaml", "document.querySelector('.facts li') !== null"
    )
    studio.take("8-compare")
    studio.go(f"#select={SEQ}", "document.querySelector('.inspector .ports') !== null")
    page.key("Delete")
    page.wait_for(OPEN)
    studio.take("9-end", is_dark=True)
    studio.close()
    (pid,) = re.findall(r"Process ID: (\d+)", shell("rtcat /localhost/manager.mgr/eyes.mgr"))
    os.kill(int(pid), signal.SIGKILL)
    page.wait_for("document.querySelector('.react-flow__node .look-zombie') !== null")
    studio.go(f"#select={SEQ}", "document.querySelector('.inspector .remark') !== null")
    studio.take("10-zombie")


def machine(studio: Studio) -> None:
    """Take the picture of a state machine that runs, with an edit that is not in force."""
    page = studio.page
    create = "StateMachine?instance_name=Patrol&conf.default.service=patrol"
    shell(f"rtmgr -c '{create}' /localhost/manager.mgr")
    shell("rtact /localhost/Patrol.rtc")
    shell(f"rtset patrol.machine --file {PATROL}")
    shell("rtset patrol.run start")
    shell("rtset patrol.event go")
    studio.go("#view=machine&of=patrol", "document.querySelector('.state.is-active') !== null")
    page.key("n")
    page.wait_for("document.querySelector('.react-flow__node[data-id=state1]') !== null")
    page.click(".react-flow__node[data-id='patrol.back'] header")
    page.wait_for("document.querySelector('.machine-inspector .actions') !== null")
    studio.take("state-machine")


def main() -> None:
    """Run a system of its own, in a folder of its own."""
    with TemporaryDirectory(prefix="rtkit-", dir="/tmp") as home:
        os.environ |= {"HOME": home, "XDG_RUNTIME_DIR": f"{home}/run", "TMPDIR": home}
        os.makedirs(f"{home}/run", 0o700)
        os.makedirs(f"{home}/robots")
        for line in SYSTEM.strip().splitlines():
            shell(line)
        try:
            with served(f"{home}/robots") as address, browser.opened(home, "", "") as page:
                page.picture(os.devnull, *SIZE)
                page.go(address)
                situations(Studio(page), f"{home}/robots")
                machine(Studio(page))
        finally:
            shell("rtmgr stop")


if __name__ == "__main__":
    main()
