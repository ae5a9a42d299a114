"""Robots and their world as components, in one module: a profile exchanges robots by one word."""

from __future__ import annotations

from rtkit import init_of
from rtkit.services.legged import LeggedRobot
from rtkit.services.mobilerobot import DifferentialRobot
from rtkit.services.world import HomeWorld

DifferentialRobotInit = init_of(DifferentialRobot)
LeggedRobotInit = init_of(LeggedRobot)
HomeWorldInit = init_of(HomeWorld)
