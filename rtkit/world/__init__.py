"""Simulates a flat world for trials: walls, bodies, sensors, and cycles in lockstep.

The extra ``sim`` installs numpy, which the walls need. Lengths are metres, angles radians
counter-clockwise, times seconds. Nothing here knows a robot or an algorithm.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rtkit.world.body import Body as Body
    from rtkit.world.body import Bumper as Bumper
    from rtkit.world.camera import Ball as Ball
    from rtkit.world.camera import photo as photo
    from rtkit.world.camera import png as png
    from rtkit.world.contact import Contact as Contact
    from rtkit.world.lockstep import Lockstep as Lockstep
    from rtkit.world.lockstep import ParticipantLost as ParticipantLost
    from rtkit.world.noise import Noise as Noise
    from rtkit.world.noise import Odometry as Odometry
    from rtkit.world.scene import Scene as Scene
    from rtkit.world.shapes import Polygon as Polygon
    from rtkit.world.shapes import Pose as Pose
    from rtkit.world.shapes import moved as moved

_NAMES = {
    "body": "Body Bumper",
    "camera": "Ball photo png",
    "contact": "Contact",
    "lockstep": "Lockstep ParticipantLost",
    "noise": "Noise Odometry",
    "scene": "Scene",
    "shapes": "Polygon Pose moved",
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return __dir__()
    if name not in _HOMES:
        raise AttributeError(f"module 'rtkit.world' has no attribute {name!r}")
    from importlib import import_module

    try:
        return getattr(import_module(f"rtkit.world.{_HOMES[name]}"), name)
    except ModuleNotFoundError as error:
        if error.name != "numpy":
            raise
        from rtkit.extras import how_to_get

        raise ImportError(f"rtkit.world needs numpy: {how_to_get('sim')}") from error


def __dir__() -> list[str]:
    return sorted(_HOMES)
