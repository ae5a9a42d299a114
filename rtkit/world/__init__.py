"""Simulates a flat world for trials: walls, bodies, sensors, and cycles in lockstep.

The extra ``sim`` installs numpy, which the walls need. Lengths are metres, angles radians
counter-clockwise, times seconds. Nothing here knows a robot or an algorithm.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rtkit.world.body import Body, Bumper
    from rtkit.world.contact import Contact
    from rtkit.world.lockstep import Lockstep, ParticipantLost
    from rtkit.world.noise import Noise, Odometry
    from rtkit.world.scene import Scene
    from rtkit.world.shapes import Polygon, Pose, moved

_HOMES = {
    "Body": "rtkit.world.body",
    "Bumper": "rtkit.world.body",
    "Contact": "rtkit.world.contact",
    "Lockstep": "rtkit.world.lockstep",
    "Noise": "rtkit.world.noise",
    "Odometry": "rtkit.world.noise",
    "ParticipantLost": "rtkit.world.lockstep",
    "Polygon": "rtkit.world.shapes",
    "Pose": "rtkit.world.shapes",
    "Scene": "rtkit.world.scene",
    "moved": "rtkit.world.shapes",
}
__all__ = [
    "Body",
    "Bumper",
    "Contact",
    "Lockstep",
    "Noise",
    "Odometry",
    "ParticipantLost",
    "Polygon",
    "Pose",
    "Scene",
    "moved",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'rtkit.world' has no attribute {name!r}")
    from importlib import import_module

    try:
        return getattr(import_module(_HOMES[name]), name)
    except ModuleNotFoundError as error:
        if error.name != "numpy":
            raise
        raise ImportError("rtkit.world needs numpy: pip install 'rtkit[sim]'") from error


def __dir__() -> list[str]:
    return sorted(__all__)
