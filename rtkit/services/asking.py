"""Base of services that ask other ones: their client, and where frames of a name stand."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Self

import rtkit
from rtkit.services.frames import Pose

_NOT_THERE = ("unknown", "no-service", "syntax")


class Asking:
    """Base of services that ask other ones.

    Args:
        resource: Name of the service that keeps named frames.
    """

    def __init__(self, resource: str = "resource") -> None:
        self._resource = resource
        self._client: rtkit.Client | None = None
        self._client_lock = threading.Lock()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def _asked(self) -> rtkit.Client:
        with self._client_lock:
            if self._client is None:
                self._client = rtkit.Client()
            return self._client

    def _pose_of(self, name: str) -> Pose:
        """Return the pose in the world of a service, of a part of one, or of a named frame."""
        return pose_in_world(self._asked().get, name, self._resource)


def pose_in_world(get: Callable[..., Any], name: str, resource: str = "resource") -> Pose:
    """Return the pose in the world of a service, of a part of one, or of a named frame [m, rad].

    Args:
        get: Gets a property, as `Client.get` does.
        name: ``robots/r1``, ``robots/r1.sensors.eye``, or a frame that the resource service keeps.
        resource: Name of that service.

    Raises:
        PropertyError: It cannot be got; its code tells how.
    """
    place = f"{name}.location"
    try:
        return _pose(get(place, frame="world"))
    except rtkit.PropertyError as error:
        if error.code in _NOT_THERE:
            return _pose(get(f"{resource}.frames.{name}"))
        # Where it takes no frame it is told in the world; a sensor without a base is nowhere.
        if error.code != "bad-parameter" or "frame" in _parameters_of(get, place):
            raise
        return _pose(get(place))


def _pose(found: Any) -> Pose:
    return found if isinstance(found, tuple) else ()


def _parameters_of(get: Callable[..., Any], target: str) -> list[str]:
    return [str(each[0]) for each in get(f"{target}.parameters")]
