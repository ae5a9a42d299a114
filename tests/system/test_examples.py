"""The examples of the manual pages are run, on a robot made of what they speak of.

A new command's examples are run without being told here: they succeed, or have a row below that
says what must be there first (`BEFORE`), that they go on until Ctrl-C (`ENDLESS`), or what else
than 0 they end with (`STATUS`).
"""

from __future__ import annotations

import os
import shlex
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from forked import Commands
from make_commands import examples
from serialkit import Cable

from rtkit.cli.shared.commands import COMMANDS, WORDS
from rtkit.link.tcp_endpoint import free_port

ROOT = Path(__file__).parents[2]
MODULE = '''
from enum import Enum
from typing import Protocol

from rtkit.component import (
    Component, InPort, OutPort, Parameter, Point2D, ServicePort, TimedDouble, TimedLong,
    TimedPoint2D, TimedPose2D, TimedVelocity2D,
)


class Robot(Component):
    """Says where it is, and fails when it turns too fast."""

    vendor, category, version, rate = "me", "example", "1.0", 50.0
    velocity = InPort(TimedVelocity2D)
    speed_ = InPort(TimedLong)
    way = InPort(TimedPoint2D)
    pose = OutPort(TimedPose2D)
    speed = Parameter(1.0)
    turn = Parameter(0.0)

    def on_execute(self, context):
        if self.turn > 90:
            raise ValueError("too fast")
        self.pose.write(TimedPose2D())


class Sensor(Component):
    """Measures."""

    vendor, category, version, rate = "me", "example", "1.0", 50.0
    range = OutPort(TimedDouble)
    scan = OutPort(TimedDouble)

    def on_execute(self, context):
        self.scan.write(TimedDouble())


class Control(Component):
    """Turns a range into a speed, and listens to the pose."""

    vendor, category, version = "me", "example", "1.0"
    range = InPort(TimedDouble)
    pose = InPort(TimedPose2D)
    speed = OutPort(TimedDouble)


class Pace(Enum):
    SLOW = 0
    FAST = 1


class Gripper(Protocol):
    def close(self, force: float) -> bool: ...
    def move(self, to: Point2D, pace: Pace) -> None: ...
    def width(self) -> float: ...


class Hand(Component):
    """Grips."""

    vendor, category, version = "me", "example", "1.0"
    gripper = ServicePort.provided(Gripper)

    def close(self, force):
        return True

    def move(self, to, pace):
        pass

    def width(self):
        return 0.1


class Asking(Component):
    """Asks a user for numbers."""

    vendor, category, version, rate = "me", "example", "1.0", 50.0

    def on_execute(self, context):
        input("a number: ")


def RobotInit(manager):
    for each in (Robot, Sensor, Control, Hand, Asking):
        manager.register_factory(each)
'''
OLD = """
import sys
import OpenRTM_aist
import RTC

consolein_spec = ["implementation_id", "ConsoleIn", "type_name", "ConsoleIn",
                  "description", "Writes numbers", "version", "1.0", "vendor", "me",
                  "category", "example", "language", "Python", ""]


class ConsoleIn(OpenRTM_aist.DataFlowComponentBase):
    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        self._d_out = RTC.TimedLong(RTC.Time(0, 0), 0)
        self._outOut = OpenRTM_aist.OutPort("out", self._d_out)

    def onInitialize(self):
        self.addOutPort("out", self._outOut)
        return RTC.RTC_OK

    def onExecute(self, ec_id):
        self._d_out.data = 1
        self._outOut.write()
        return RTC.RTC_OK


def ConsoleInInit(manager):
    profile = OpenRTM_aist.Properties(defaults_str=consolein_spec)
    manager.registerFactory(profile, ConsoleIn, OpenRTM_aist.Delete)


def MyModuleInit(manager):
    ConsoleInInit(manager)
    manager.createComponent("ConsoleIn")


def main():
    mgr = OpenRTM_aist.Manager.init(sys.argv)
    mgr.setModuleInitProc(MyModuleInit)
    mgr.activateManager()
    mgr.runManager()


if __name__ == "__main__":
    main()
"""
SERVED = """
class Robot:
    def __init__(self):
        self.speed = 0.5
        self.location = [1.0, 2.0, 3.0]
        self.mode = "idle"
        self.image = b"..."

    def double(self, number: float) -> float:
        return 2 * number


class Arm:
    angle = 0.0
"""
INIT = "def RobotInit(manager):\n    manager.register_factory(Robot)\n"
MADE = (
    "Robot?instance_name=Robot0&conf.careful.speed=0.1&conf.careful.turn=0",
    "Robot?instance_name=Robot1&conf.careful.speed=0.1&conf.careful.turn=0",
    *(f"Sensor?instance_name={name}" for name in ("Sensor0", "Laser0", "A", "B", "C")),
    *(f"Control?instance_name={name}" for name in ("Control0", "Map0", "Left", "Right")),
    "ConsoleIn?instance_name=A0",
    "ConsoleIn?instance_name=B0",
    "ConsoleIn?instance_name=Arm0&manager_name=arm",
    "Hand?instance_name=Hand0",
    "Asking?instance_name=ConsoleIn0&manager_name=asking",
    "Microwave?instance_name=Microwave0",
    "Motor?instance_name=Motor0",
    "Sensor?instance_name=Old0&naming.formats=old.host_cxt/%n.rtc",
    "Sensor?instance_name=Eye0&naming.formats=robot.host_cxt/%n.rtc",
)
"""What is there when the examples begin."""

STATES = "".join(
    f'<rtsExt:Properties rtsExt:name="rtkit.{name}" rtsExt:value="{value}"/>'
    for name, value in (
        ("states", "idle, dock"),
        ("transitions", "idle -start-> dock; dock -start-> idle"),
        ("state.idle", "*=Inactive"),
        ("state.dock", "*=Inactive; Sensor0=Active"),
    )
)

LAST = ("rtcomp", "rtexit", "rtdel")
"""Commands whose examples leave others without what they need, in this order."""

WIRE = "rtcon -i range Sensor0.rtc:range Control0.rtc:range"
SAVED = ("rtdis Sensor0.rtc", WIRE, "rtcryo -n Robot -o robot.xml")
RECORDED = ("rm run.mcap", "rtact -e all Robot0.rtc", "rtlog -f run.mcap -i -e 2 Robot0.rtc:pose")
BEFORE: dict[str, tuple[str, ...]] = {
    "rtattach --send 5 /localhost/ConsoleIn0.rtc": ("rtact ConsoleIn0.rtc",),
    "rtlog --export csv -f run.mcap": RECORDED,
    "rtcheck robot.xml": (*SAVED, "rtstart robot.xml"),
    "rtcheck -s inactive --json robot.xml": ("rtstop robot.xml",),
    "rtcon -d -i range Sensor0.rtc:range Control0.rtc:range": ("rtdis Sensor0.rtc",),
    "rtconf /localhost/Robot1.rtc import robot.json": ("rtconf Robot0.rtc export robot.json",),
    "rtcwd ..": ("rtpwd",),
    "rtdis -i range /localhost/Sensor0.rtc:range": (WIRE,),
    "rtdis Sensor0.rtc:range Control0.rtc:range": (WIRE,),
    "rtfsm Microwave0.rtc setstructure microwave.scxml": (
        "rtfsm Microwave0.rtc getstructure > microwave.scxml",
    ),
    "rtlog -d -f run.mcap": RECORDED,
    "rtlog -f run.mcap Robot0.rtc:pose": ("rm run.mcap", "rtact Robot0.rtc"),
    "rtlog -a -f run.mcap": ("rm run.mcap",),
    "rtlog -f run.mcap 'Robot*:pose'": ("rm run.mcap",),
    "rttype show -f run.mcap RTC::TimedPose2D": RECORDED,
    "rtmove -n /localhost/Motor0.rtc /localhost/m2.mgr": ("rtmgr start m2",),
    "rtprint Robot0.rtc:pose": ("rtact Robot0.rtc",),
    "rtprint -n 1 -f data.position.x Robot0.rtc:pose": ("rtact Robot0.rtc",),
    "rtprint -t 2 --json A0.rtc:out B0.rtc:out": ("rtact A0.rtc B0.rtc",),
    "rtreset /localhost/Robot0.rtc": (
        "rtact Robot0.rtc",
        "rtconf Robot0.rtc set turn 99",
        "rtwait Robot0.rtc error",
        "rtconf Robot0.rtc set turn 0",
    ),
    "rtresurrect robot.xml": SAVED,
    "rtstart robot.xml": SAVED,
    "rtstate robot.xml": (*SAVED, "tell-states robot.xml"),
    "rtstodot robot.xml > robot.dot": SAVED,
    "rtserve ./arm.py:Arm arm --tls 0.0.0.0:4711": ("rtkeys init",),
    "rtteardown robot.xml": SAVED,
    "rtvlog -f stdout /localhost/manager.mgr/drives.mgr": (
        "rtmgr -c ConsoleIn?manager_name=drives /localhost/manager.mgr",
    ),
    "rtwait -t 10 Robot0.rtc active": ("rtact Robot0.rtc",),
    "rtwait A.rtc B.rtc active Laser0.rtc:scan data": ("rtact A.rtc B.rtc Laser0.rtc",),
    "rtcomp -a Sensor0.rtc:range -a Control0.rtc /localhost/manager.mgr:Robot0": (
        "rtexit Robot0.rtc",
        # Those of before went with the system that was taken down.
        "rtmgr -c Sensor?instance_name=Sensor0 /localhost/manager.mgr",
        "rtmgr -c Control?instance_name=Control0 /localhost/manager.mgr",
    ),
    "rtexit --force /localhost/Robot0.rtc": (
        "rtmgr -c 'Robot?instance_name=Robot0&manager_name=robot' /localhost/manager.mgr",
    ),
    "rtdel -z /localhost/Robot0.rtc": (
        "rtmgr -c 'Robot?instance_name=Robot0&manager_name=robot' /localhost/manager.mgr",
        "kill robot",
    ),
    "rtmgr -m corbaloc::localhost:2811": (),
    "rtbuild robot.yaml -o robot -I idl": ("rtprofile convert Robot.xml robot.yaml",),
    "rtbuild Arm.xml Hand.xml -o arms": (
        "rtprofile new component Arm --out angle:TimedDouble",
        "rtprofile new component Hand --out width:TimedDouble",
    ),
    "rtbuild Wrist.xml -o arms --add": ("rtprofile new component Wrist --in angle:TimedDouble",),
    "rtprofile diff robot.xml robot.new.xml": ("cp robot.xml robot.new.xml",),
    "rtprofile new system Robot --component Motor.xml:Left --component Eye.xml "
    "--connect Eye0.speed=Left.speed": (
        "rm Robot.xml",
        "rtprofile new component Eye --out speed:TimedDouble",
    ),
    "rtprofile convert robot.xml robot.yaml": ("rm robot.yaml",),
    "rtprofile normalise -i *.xml": ("rm RTC.xml",),
    # Its revision is 1 at first.
    "rtset --if 7 robot.mode drive": tuple(f"rtset robot.mode m{n}" for n in range(6)),
}
"""What is typed before an example, so that it can do what it says."""

ENDLESS = {
    "rtbug run --all --out runs",  # over a minute
    "rtdev robot.xml",
    "rtdev -s inactive robot.xml",
    "rtopenrtm run ConsoleIn.py",
    "rtopenrtm run ConsoleIn.py -f rtc.conf",
    "rtlisten robot.speed",
    "rtlisten /localhost/Robot0.rtc.ports.pose.count",
    "rtlisten --mode diff robot",
    "rtls -l --watch=0.5 /localhost",
    "rtlog -f run.mcap Robot0.rtc:pose",
    "rtlog -a -f run.mcap",
    "rtlog -f run.mcap 'Robot*:pose'",
    "rtprint Robot0.rtc:pose",
    "rtprint --plot Robot0.rtc:pose",
    "rtstate --follow robot.xml",
    "rttop",
    "rttop -s CPU% /localhost/manager.mgr",
    *(line for line, _ in examples()["rtserve"]),
    *(line for line, _ in examples()["rtweb"] if "--cert" not in line),
    "rtvlog /localhost/Robot0.rtc",
    "rtvlog -l warn /",
    "rtvlog -f stdout /localhost/manager.mgr/drives.mgr",
    "rtwatch /",
    "rtwatch -f rtc_status Robot0.rtc Arm0.rtc",
    "rtwatch -n 1 -t 60 -f tree_event Robot0.rtc",
    "rtwatch --json / > events.jsonl",
}
STATUS = {
    "rtbug run --world visited --variant alg1 --sensors laser --watch": (1,),  # no terminal
    "rtcheck --diff robot.xml": (0, 1),
    "rtconf /localhost/Robot0.rtc diff careful": (1,),
    "rtdoctor": (0, 1),
    **{line: (1,) for line, _ in examples()["rtgui"]},  # no terminal
    "rtplan --cost Motor0=1000 robot.xml": (0, 2),  # there is no Motor0 here
    "rtplan --detailed-exitcode robot.xml": (0, 2),
    "rtdoctor --strict --json": (0, 1),
    "rtstate robot.xml": (0, 1),
    # Address and keys are those of another machine.
    "rtweb --bind 10.0.0.7 --cert robot.crt --key robot.key": (1,),
    "rtstate --unfollow Robot": (0, 1),  # the interruption may come before it is followed
}
"""Examples that may end otherwise: what they look at is this machine, or was changed before."""

ELSEWHERE = ("rthost", "rtkeys", "rtmgr", "rtpkg", "rtproxy")
"""Commands that start managers, or need hosts or packages: they have places of their own."""


class World:
    """A folder with files, and a manager with components, that examples are typed at."""

    def __init__(self, shell: Any, environment: dict[str, str]) -> None:
        self.shell = shell
        self.folder = shell.folder
        self.commands = Commands(environment, shell.folder)

    def type(self, line: str, *, is_endless: bool = False) -> tuple[int, str]:
        """Type a line as a shell takes it and return its status and what it says."""
        status, text = 0, ""
        for part in line.split(" | "):
            words = shlex.split(part)
            if words[0] in ("rm", "cp", "kill", "tell-states"):
                self._do(*words)
                continue
            into = words[words.index(">") + 1] if ">" in words else ""
            if "<" in words:
                text = (self.folder / words[words.index("<") + 1]).read_text()
            argv = [each for word in _plain(words) for each in self._globbed(word)]
            told = self.commands.run(argv, text, is_endless=is_endless)
            status, text = told["status"], told["out"]
            if into:
                (self.folder / into).write_text(text)
            if status:
                return status, told["out"][-300:] + told["err"]
        return status, text[-300:]

    def _globbed(self, word: str) -> list[str]:
        if not word.startswith("*."):  # any other pattern is quoted, and for the command
            return [word]
        return sorted(path.name for path in self.folder.glob(word)) or [word]

    def _do(self, what: str, *names: str) -> None:
        if what == "kill":
            out = self.commands.run(["rtcat", "--json", f"/localhost/manager.mgr/{names[0]}.mgr"])
            pid = int(out["out"].split('"pid": ')[1].split(",")[0].rstrip("}\n"))
            pidfd = os.pidfd_open(pid)
            signal.pidfd_send_signal(pidfd, signal.SIGKILL)
            os.close(pidfd)
            waited = self.commands.run(["rtwait", "Robot0.rtc", "exists", "-t", "0.01"])
            while "zombie" not in waited["err"]:
                waited = self.commands.run(["rtwait", "Robot0.rtc", "exists", "-t", "0.01"])
        elif what == "tell-states":
            text = (self.folder / names[0]).read_text()
            end = "</rts:RtsProfile>"
            (self.folder / names[0]).write_text(text.replace(end, STATES + end))
        elif what == "rm":
            (self.folder / names[0]).unlink(missing_ok=True)
        else:
            shutil.copy(self.folder / names[0], self.folder / names[1])


def _plain(words: list[str]) -> Iterator[str]:
    skip = False
    for word in words:
        if not skip and word not in ("<", ">"):
            yield word
        skip = word in ("<", ">")


def wrong_of(world: World, names: list[str]) -> dict[str, tuple[int, str]]:
    """Run the examples of commands and return those that did not do what they should."""
    wrong = {}
    for name in names:
        for line, _ in examples()[name]:
            for each in BEFORE.get(line, ()):
                status, told = world.type(each)
                if status:
                    wrong[f"{line}: before it: {each}"] = (status, told)
            typed = line.replace("2811", PORT).replace("8080", PORT).replace("/dev/ttyS0", DEVICE)
            status, told = world.type(typed, is_endless=line in ENDLESS)
            expected = (-signal.SIGINT, 0) if line in ENDLESS else STATUS.get(line, (0,))
            if status not in expected or "Traceback" in told:
                wrong[line] = (status, told)
    return wrong


PORT = str(free_port())
DEVICE = "ttyS0"
"""A serial line in the folder of the test."""


def prepare(shell: Any) -> dict[str, str]:
    """Put the files there of which examples speak; return the environment of commands."""
    folder = shell.folder
    (folder / "Things.py").write_text(MODULE)
    alone = f"{MODULE.partition('class Sensor')[0]}\n{INIT}"
    (folder / "Robot.py").write_text(alone)
    (folder / "Arm.py").write_text(alone.replace("Robot", "Arm"))
    shutil.copy(ROOT / "profiles" / "Motor.xml", folder / "RTC.xml")
    shutil.copy(ROOT / "profiles" / "Motor.xml", folder / "Robot.xml")
    shutil.copy(ROOT / "tests" / "idl" / "MyService.idl", folder)
    for name in ("robot.py", "arm.py"):
        (folder / name).write_text(SERVED)
    (folder / "image.jpg").write_text("...")
    (folder / "answers.txt").write_text("6\n7\n")
    (folder / "ConsoleIn.py").write_text(OLD)
    (folder / "rtc.conf").write_text("exec_cxt.periodic.rate: 50\n")
    (folder / "robot.conf").write_text("logger.log_level: DEBUG\n")
    (folder / "points.jsonl").write_text('{"data": {"x": 1, "y": 2}}\n')
    for name in ("idl", "native", "profiles", "robots", "systems"):
        (folder / name).mkdir()
    for name in ("profiles", "systems"):
        shutil.copy(ROOT / "profiles" / "Motor.xml", folder / name / "Motor.xml")
    paths = (str(ROOT / "tests/support"), shell.environment["PYTHONPATH"])
    return {
        **shell.environment,
        "BROWSER": "true",  # which opens nothing
        "RTCSH_CWD": "/localhost",
        "PYTHONPATH": os.pathsep.join(paths),
    }


@pytest.mark.timeout(300)
def test_every_example_runs(shell: Any) -> None:
    world = World(shell, prepare(shell))
    serving = shell.open("rtserve ./robot.py:Robot robot")
    cable = Cable(str(shell.folder))
    os.symlink(cable.near, shell.folder / DEVICE)
    try:
        assert serving.stdout.readline() == "/localhost/robot\n"
        assert world.type("rtmgr start") == (0, "")
        made = " ".join(f"-c {shlex.quote(each)}" for each in MADE)
        line = f"rtmgr /localhost/manager.mgr -l ./Things.py:RobotInit {made}"
        assert world.type(line) == (0, "")
        for line in SAVED:
            assert world.type(line) == (0, ""), line
        usual = [name for name in examples() if name not in (*LAST, *ELSEWHERE)]
        wrong = wrong_of(world, [*usual, *LAST])
        assert wrong == {}, "\n".join(f"{line}: {told}" for line, told in wrong.items())
    finally:
        world.commands.close()
        cable.close()
        serving.terminate()
        assert shell.end_of(serving) == (0, "", "")


@pytest.mark.timeout(300)
def test_every_example_that_starts_managers_runs(shell: Any) -> None:
    world = World(shell, prepare(shell))
    try:
        assert wrong_of(world, ["rtmgr"]) == {}
    finally:
        world.type("rtmgr stop other")
        world.commands.close()


def test_rows_name_examples_that_there_are() -> None:
    lines = {line for each in examples().values() for line, _ in each}
    assert {*BEFORE, *ENDLESS, *STATUS} <= lines
    assert examples().keys() == {*COMMANDS.values(), "rtkit"}
    assert WORDS
