"""The simulated world as a component: its tick drives all others in lockstep."""

from __future__ import annotations

from pathlib import Path
from time import monotonic

from rtkit.component import (
    Component,
    InPort,
    Manager,
    OutPort,
    Parameter,
    Point2D,
    Pose2D,
    RangeData,
    TimedBooleanSeq,
    TimedDoubleSeq,
    TimedPose2D,
    TimedVelocity2D,
)
from rtkit.errors import NotFound, Refused
from rtkit.world import Lockstep, ParticipantLost

from .environments import read_environments, shipped
from .messages import ONE_EACH_TICK, Body, Navigation, time_of
from .simulation import Simulation

_PATIENCE_S = 2.0


class WorldSim(Component):
    """Move a robot with a differential drive among polygons, a control step after the other.

    A run begins when it is activated. In each step it writes what the sensors see, gives each of
    the driven components a cycle, one after the other, and moves the robot as it is told.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    rate = 1000.0

    cmd = InPort(TimedVelocity2D, properties=ONE_EACH_TICK, doc="How to move until the next step")
    navigation = InPort(Navigation, properties=ONE_EACH_TICK, doc="Whether the run is over")
    pose = OutPort(TimedPose2D, doc="Where odometry takes the robot to be [m, rad]")
    scan = OutPort(RangeData, doc="Laser: 181 beams from right to left [m]")
    ir = OutPort(TimedDoubleSeq, doc="Three infra-red cones: ahead, left, right [m]")
    bumper = OutPort(TimedBooleanSeq, doc="Six switches, the first one ahead, counter-clockwise")
    body = OutPort(Body, doc="Where the robot is, and what happened to it")
    run = Parameter("run", doc="Name of the run; another one begins the world anew")
    world = Parameter("one-box", doc="Which of the worlds")
    sensors = Parameter(
        "laser", constraint="(laser,ir,laser+ir,bumper)", doc="Which sensors the robot has"
    )
    environments = Parameter("", doc="Files of further worlds, with : between them")
    drives = Parameter("", doc="Components that get a cycle in each step, in this order")
    noise = Parameter(0.0, unit="m", constraint="0<=x<=1", doc="Sigma of ranges and odometry")
    seed = Parameter(0, constraint="x>=0", doc="Of the noise")
    speedup = Parameter(
        0.0, constraint="x>=0", doc="How many times as fast as real time; 0: no waiting"
    )
    step_limit = Parameter(20000, constraint="x>0", doc="After so many steps the run is over")

    def on_activated(self, context: str) -> None:
        """Put the robot at its start."""
        worlds = shipped()
        for file in filter(None, self.environments.split(":")):
            worlds |= read_environments(Path(file).read_text("utf-8"), file)
        if self.world not in worlds:
            raise NotFound(f"no world {self.world}; known: {', '.join(worlds)}")
        world = worlds[self.world]
        self._simulation = Simulation(world, self.seed, self.noise, self.sensors)
        self._is_over, self._trouble = False, ""
        prefix = self.instance.removesuffix("WorldSim0")
        names = [prefix + name.strip() for name in self.drives.split(",") if name.strip()]
        self._lockstep = Lockstep(*names, timeout_s=_PATIENCE_S)
        self._began = monotonic()
        for port in (self.cmd, self.navigation):
            port.read_all()

    def on_deactivated(self, context: str) -> None:
        """Drive nobody any more."""
        self._lockstep.close()

    def on_execute(self, context: str) -> None:
        """Do a step if its time has come; where a component is lost, time stands still."""
        simulation, lockstep = self._simulation, self._lockstep
        is_due = not self.speedup or (monotonic() - self._began) * self.speedup >= simulation.t
        if self._is_over or not is_due:
            return
        is_last = simulation.steps >= self.step_limit
        if not lockstep.is_under_way:
            self._write(is_last)
        try:
            lockstep.tick()
        except ParticipantLost as lost:
            if str(lost) != self._trouble:
                self._trouble = str(lost)
                self.report(self._trouble)
            return
        self._trouble = ""
        command, navigation = self.cmd.read(), self.navigation.read()
        if command is None or navigation is None:
            raise Refused("no command came in this step: is the navigator connected?")
        self._is_over = is_last or bool(navigation.status)
        if not self._is_over:
            simulation.step(command.data.vx, command.data.va)

    def _write(self, is_last: bool) -> None:
        """Write what is to be seen now, to those who are connected."""
        simulation = self._simulation
        tm, raw = time_of(simulation.t), simulation.raw()
        x, y, theta = raw.odometry
        self.pose.write(TimedPose2D(tm, Pose2D(Point2D(x, y), theta)))
        self.scan.write(RangeData(tm, raw.scan))
        self.ir.write(TimedDoubleSeq(tm, raw.ir))
        self.bumper.write(TimedBooleanSeq(tm, raw.bumper))
        touched = simulation.collisions, simulation.min_clearance
        self.body.write(Body(tm, *simulation.pose, *touched, is_last))


def WorldSimInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(WorldSim)
