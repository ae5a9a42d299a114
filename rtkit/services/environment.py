"""Environment model: what sensors have seen, fused; one for each robot, or one that all share.

``SET observe <marker>`` takes what was seen, ``GET markers`` tells the things there are, each once
(`rtkit.services.fusion`). ``SET grids.temperature.observe (x y v)`` takes what was measured at a
place (`rtkit.services.grids`). ``SET merge SERVICE`` takes what another model knows.
"""

from __future__ import annotations

import copy
import math
import threading
import time
import uuid
from typing import Annotated, Any, Final

import rtkit
from rtkit import init_of
from rtkit.services.asking import Asking
from rtkit.services.frames import ORIGIN, Frames
from rtkit.services.fusion import MarkerFusion
from rtkit.services.grids import Grids, Share
from rtkit.services.sensor import moved, within


class Environment(Asking):
    """Fuses markers of many sensors into the things that there are.

    Args:
        variance: Of each coordinate of a marker that tells none [m², rad²].
        gate: Mahalanobis distance up to which a marker may be of a thing.
        drift: Growth of the variance of the place of a thing [m²/s, rad²/s].
        maxage: After which time what was not seen is forgotten [s]; 0 for never.
        side: Of a cell of the grids [m].
        most: How many things are kept.

    Attributes:
        frame: In which things are kept: ``world``, or the name of a service.
        maxage: After which time what was not seen is forgotten [s]; 0 for never.
        grids: Grids of measured values, by name.
    """

    type: Final = ("environment",)
    version: Final = "1.0"
    status: Final = "ready"
    frame: Final[str]

    def __init__(
        self,
        frame: str = "world",
        *,
        variance: float = 0.01,
        gate: float = 3.4,
        drift: float = 0.01,
        maxage: float = 60.0,
        side: float = 0.5,
        most: int = 1000,
    ) -> None:
        super().__init__()
        for name, given in (("variance", variance), ("gate", gate), ("side", side)):
            within(name, given, 1e-9)
        for name, given, low in (("drift", drift, 0), ("maxage", maxage, 0), ("most", most, 1)):
            within(name, given, low)
        self.frame = frame
        self.maxage: Annotated[float, rtkit.Unit("s"), rtkit.Range(0)] = maxage
        self._id = uuid.uuid4().hex[:12]
        self.grids = Grids(side, self._id)
        self._own = self._model = MarkerFusion(variance, gate, drift, most, frame)
        self._shares: dict[str, tuple[int, list[rtkit.Marker]]] = {}
        self._lock = threading.Lock()
        self._frames = Frames(self._pose_of)

    def get_markers(
        self,
        type: str = "",
        near: tuple[float, float, float] | None = None,
        since: float = 0.0,
        frame: str = "",
    ) -> list[rtkit.Marker]:
        """Things that there are: of a type, within r of a place (x y r), seen since a time."""
        with self._lock:
            self._forget()
            things = list(self._model.things())
        found = [each for each in things if (each.time or 0.0) > since]
        if frame not in ("", self.frame):
            pose = self._frames.between(self.frame, frame)
            found = [moved(each, pose, frame) for each in found]
        return [each for each in found if _is_near(each, near) and type in ("", each.type)]

    def set_observe(self, seen: list[rtkit.Marker] | rtkit.Marker, frame: str = "") -> None:
        """One marker, or all that a sensor sees at one time; none counts if one is refused.

        A marker without a frame is in that of the request; without one either in the frame of the
        model.
        """
        markers = [seen] if isinstance(seen, rtkit.Marker) else seen
        placed = [self._placed(each, frame) for each in markers]
        with self._lock:
            for each in {self._own, self._model}:
                each.observe(placed, time.time())

    def get_shares(self) -> list[tuple[str, int, list[rtkit.Marker]]]:
        """Of each model known here its id, how much it has seen by itself, and those things."""
        with self._lock:
            self._forget()
            own = (self._id, self._own.count, list(self._own.things()))
            return [own, *((model, *share) for model, share in self._shares.items())]

    def set_merge(self, model: str) -> None:
        """Service of another model: what it knows, and was not known here, counts here, too."""
        shares, measured = self._shares_of(model)
        with self._lock:
            for id, count, markers in shares:
                if id != self._id and count > self._shares.get(id, (0,))[0]:
                    if self._model is self._own:  # from now on it knows more than it has seen
                        self._model = copy.deepcopy(self._own)
                    self._model.merge(id, markers, time.time())
                    self._shares[id] = count, markers
        for name, each in measured.items():
            self.grids._merge(name, each)  # noqa: SLF001  no action

    def _shares_of(
        self, model: str
    ) -> tuple[list[tuple[str, int, list[rtkit.Marker]]], dict[str, list[Share]]]:
        """Return what a service tells that models have seen, and measured by names of grids."""
        get = self._asked().get
        listed = get(f"{model}.shares")
        grids = get(f"{model}.properties", all=True, match="grids.*.shares")
        cells = {each.split(".")[1]: get(f"{model}.{each}") for each in grids}
        try:
            shares = [
                (str(id), int(count), [self._placed(each, "") for each in markers])
                for id, count, markers in listed
            ]
            measured = {name: [*map(_share, each)] for name, each in cells.items()}
        except (TypeError, ValueError, AttributeError):
            raise rtkit.PropertyError(
                "bad-value", f"no model that can be merged: {model}"
            ) from None
        return shares, measured

    def _forget(self) -> None:
        """Forget what was not seen for too long."""
        if self.maxage > 0:
            before = time.time() - self.maxage
            for each in {self._own, self._model}:
                each.forget(before)
            self._shares = {
                id: (count, markers)
                for id, (count, markers) in self._shares.items()
                if any((each.time or 0.0) >= before for each in markers)
            }

    def _placed(self, marker: rtkit.Marker, frame: str) -> rtkit.Marker:
        """Return a marker in the frame of the model."""
        own = marker.frame or frame or self.frame
        pose = ORIGIN if own == self.frame else self._frames.between(own, self.frame)
        return marker if pose is ORIGIN else moved(marker, pose, self.frame)


def _share(value: Any) -> Share:
    """Return what a model has measured in a grid; ValueError, TypeError: it is something else."""
    id, side, rows = value
    return str(id), float(side), [(int(x), int(y), int(n), float(v)) for x, y, n, v in rows]


def _is_near(marker: rtkit.Marker, near: tuple[float, float, float] | None) -> bool:
    return near is None or math.dist((marker.location or ())[:2], near[:2]) <= near[2]


EnvironmentInit = init_of(Environment)
