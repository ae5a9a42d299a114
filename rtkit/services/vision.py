"""Vision, a sensor: what methods find in the pictures of cameras, as pictures, segments, markers.

A method computes when its result is asked for, or listened to, and once for each picture; one that
is not active computes nothing. Needs the extra ``vision``.
"""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from time import monotonic, perf_counter
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import rtkit
from rtkit import init_of
from rtkit.services import vision_methods
from rtkit.services.frames import Frames, Pose, compose, pose_of, transform
from rtkit.services.images import decode, encode, opencv
from rtkit.services.sensor import MIDDLE, Pose6, Sensor, moved, within
from rtkit.services.vision_methods import Lens

if TYPE_CHECKING:
    from rtkit.services.images import Picture

Form = Literal["", "image", "segments", "markers"]


class PictureStore:
    """Latest picture of one camera, which is got, and decoded, when it is asked for.

    Args:
        get: Returns the picture that a property of another service holds.
        source: That property; empty: the picture that was put.
        age: How old a picture may be until its source is asked again [s].
    """

    def __init__(self, get: Callable[[str], bytes], source: str, age: float) -> None:
        self.source = source
        self._get, self._age = get, age
        self._lock = threading.Lock()
        self._data = b""
        self._asked: tuple[str, float] = ("", 0.0)
        self._picture: Picture | None = None
        self._failure: rtkit.PropertyError | None = None

    def put(self, data: bytes) -> None:
        """Keep this picture; the source is asked no more."""
        picture = decode(data)
        with self._lock:
            self._data, self._picture, self.source = data, picture, ""

    def latest(self) -> tuple[bytes, Picture]:
        """Return the picture as it came, and decoded; the same objects while it is the same."""
        with self._lock:
            source = self.source
            if source and (self._asked[0] != source or monotonic() - self._asked[1] > self._age):
                self._ask(source)
            if source and self._failure is not None:
                raise self._failure
            if not self._data:
                raise rtkit.PropertyError(
                    "no-service", "no picture yet: SET image, or image.source"
                )
            if self._picture is None:
                self._picture = decode(self._data)
            return self._data, self._picture

    def _ask(self, source: str) -> None:
        """Ask the source; if it is silent, those who wait here are not to ask it once more each."""
        self._failure = None
        try:
            data = self._get(source)
            if data != self._data:
                self._data, self._picture = data, None
        except rtkit.PropertyError as error:
            self._failure = error
        self._asked = (source, monotonic())


class CameraView:
    """Camera of a vision service.

    Attributes:
        field: Angle from the left to the right of the picture [rad].
    """

    def __init__(self, store: PictureStore, field: float) -> None:
        self._location: Pose = MIDDLE
        self.field: Annotated[float, rtkit.Unit("rad"), rtkit.Range(0.01, 3.0)] = field
        self._store = store

    @property
    def location(self) -> Pose6:
        """Pose of the camera in the frame of the vision service [m, rad]."""
        return self._location  # type: ignore[return-value]

    @location.setter
    def location(self, pose: Pose6) -> None:
        self._location = pose_of(pose)

    def get_source(self) -> str:
        """Property of a service that holds the picture; empty: the one that was SET."""
        return self._store.source

    def set_source(self, source: str) -> None:
        """Process the pictures of this property."""
        self._store.source = source

    def get_image(self, format: str = "jpeg", width: int = 0) -> bytes:
        """The latest picture, as jpeg or png; 0 leaves its width as it is."""
        return encode(self._store.latest()[1], format, width)

    def set_image(self, data: bytes) -> None:
        """Process this picture, a JPEG or PNG, in place of that of the source."""
        self._store.put(data)


Chosen = tuple[str, CameraView, PictureStore]
"""Camera as methods use it: its name, what is known of it, its pictures."""
Choose = Callable[[str], Chosen]


class Method(ABC):
    """Method of vision.

    Args:
        camera: Returns the camera of a name, the chosen one for none.
        place: Returns the pose of the vision service in a frame [m, rad].

    Attributes:
        active: Whether it may compute.
        forms: In which its result can be asked for; the first one is the usual one.
        runs: How many pictures it has processed.
        seconds: How long the last one took [s].
    """

    forms: Final[tuple[Form, ...]] = ()
    runs: Final[int] = 0
    seconds: Final[Annotated[float, rtkit.Unit("s")]] = 0.0
    active: bool = False

    def __init__(self, camera: Choose, place: Callable[[str], Pose]) -> None:
        self._camera, self._place = camera, place
        self._lock = threading.Lock()
        self._known: dict[str, tuple[bytes, Any, Any]] = {}

    def get_result(
        self,
        form: Form = "",
        camera: str = "",
        format: str = "png",
        width: int = 0,
        frame: str = "base",
    ) -> Any:
        """The findings: an image (of a format and width), segments, or markers (in a frame)."""
        form = form or self.forms[0]
        if form not in self.forms:
            known = " or ".join(self.forms)
            raise rtkit.PropertyError("bad-parameter", f"form is {known}, not {form}")
        if not self.active:
            raise rtkit.PropertyError("conflict", "the method is not active: SET its `active` true")
        name, view, pictures = self._camera(camera)
        data, picture = pictures.latest()
        lens = Lens.of(picture, view.field)
        found = self._outcome(name, data, picture, lens)
        if form == "image":
            return encode(self._drawn(picture, found), format, width)
        if form == "segments":
            return [tuple(round(float(each), 3) for each in row) for row in self._segments(found)]
        pose, named = compose(self._place(frame), view.location), "" if frame == "base" else frame
        return [_placed(each, pose, named).with_(camera=name) for each in self._places(found, lens)]

    def gui_result(self) -> rtkit.Gui:
        """See `rtkit.Gui`: the result is drawn as it usually is."""
        return rtkit.Gui("image" if self.forms[0] == "image" else "map")

    def _outcome(self, name: str, data: bytes, picture: Picture, lens: Lens) -> Any:
        """Return what is found in a picture; computed once, until a setting is changed."""
        settings = {key: each for key, each in vars(self).items() if key[0] != "_"}
        settings |= {"runs": 0, "seconds": 0.0, "lens": lens}
        with self._lock:
            known = self._known.get(name)
            if known is None or known[0] is not data or known[1] != settings:
                begin = perf_counter()
                found = self._compute(picture, lens)
                setattr(self, "seconds", perf_counter() - begin)  # noqa: B010  final for others
                setattr(self, "runs", self.runs + 1)  # noqa: B010
                known = self._known[name] = (data, settings, found)
            return known[2]

    @abstractmethod
    def _compute(self, picture: Picture, lens: Lens) -> Any:
        """Return what is in a picture."""

    @abstractmethod
    def _drawn(self, picture: Picture, found: Any) -> Picture:
        """Return a picture of what was found."""

    def _segments(self, found: Any) -> Iterable[Any]:
        """Return what was found as rows ``x1 y1 x2 y2`` [pixels]."""
        return ()

    def _places(self, found: Any, lens: Lens) -> Iterable[rtkit.Marker]:
        """Return what was found as markers in the frame of the camera."""
        return ()


class EdgeMethod(Method):
    """Straight edges as segments, all edges as an image.

    Attributes:
        smooth: How much noise is smoothed away first [px].
        least: Length of the shortest segment [px].
        threshold: Steepness of an edge in the image, in grey levels.
    """

    forms: Final[tuple[Form, ...]] = ("image", "segments")  # type: ignore[misc]
    smooth: Annotated[float, rtkit.Unit("px"), rtkit.Range(0, 20)] = 1.5
    least: Annotated[float, rtkit.Unit("px"), rtkit.Range(0)] = 20.0
    threshold: Annotated[float, rtkit.Range(1, 1000)] = 120.0

    def _compute(self, picture: Picture, lens: Lens) -> Any:
        return vision_methods.segments(picture, self.smooth, self.least)

    def _drawn(self, picture: Picture, found: Any) -> Picture:
        return vision_methods.edge_picture(picture, self.smooth, self.threshold)

    def _segments(self, found: Any) -> Any:
        return found


class BlobMethod(Method):
    """Areas of one colour. Of a known diameter the place is told, else the direction only.

    Attributes:
        colors: Those that are looked for.
        least: Area of the smallest one [px²].
        diameter: Of the balls that are looked for [m]; 0 where it is not known.
    """

    forms: Final[tuple[Form, ...]] = ("markers", "image")  # type: ignore[misc]
    colors: tuple[vision_methods.Color, ...] = tuple(vision_methods.HUES)
    least: Annotated[float, rtkit.Range(1)] = 50.0
    diameter: Annotated[float, rtkit.Unit("m"), rtkit.Range(0)] = 0.0

    def _compute(self, picture: Picture, lens: Lens) -> Any:
        return vision_methods.blobs(picture, self.colors, self.least)

    def _drawn(self, picture: Picture, found: Any) -> Picture:
        return _outlined(picture, [each.outline for each in found])

    def _places(self, found: Any, lens: Lens) -> Iterable[rtkit.Marker]:
        for each in found:
            known = {
                "type": "ball" if each.is_disc else "blob", "name": each.color, "color": each.rgb,
                "pixel": tuple(round(part, 2) for part in each.center),
                "pixels": round(each.diameter, 2),
            }  # fmt: skip
            ray = lens.ray(*each.center)
            if not self.diameter:
                yield rtkit.Marker(None, polar=_polar(ray), **known)
                continue
            # A sphere fills a cone; the lens shows how wide that is where the sphere is seen.
            far = self.diameter * lens.focal / (each.diameter * ray[0])
            yield rtkit.Marker(
                tuple(far * part for part in ray), size=self.diameter,
                variance=lens.variance(far, self.diameter), **known,
            )  # fmt: skip


def _dictionaries(method: object) -> list[str]:
    return vision_methods.dictionaries()


class FiducialMethod(Method):
    """ArUco marks with pose: x to the right of the mark, y up, z out of it.

    Attributes:
        size: Side of the black square [m].
        dictionary: Of marks, as OpenCV names it.
    """

    forms: Final[tuple[Form, ...]] = ("markers", "image", "segments")  # type: ignore[misc]
    size: Annotated[float, rtkit.Unit("m"), rtkit.Range(0.001)] = 0.1
    dictionary: Annotated[str, rtkit.Choices(_dictionaries)] = "4x4_50"

    def _compute(self, picture: Picture, lens: Lens) -> Any:
        return vision_methods.fiducials(picture, lens, self.size, self.dictionary)

    def _drawn(self, picture: Picture, found: Any) -> Picture:
        return _outlined(picture, [each.corners.round().astype("int32") for each in found])

    def _segments(self, found: Any) -> Any:
        pairs = ((each.corners[at], each.corners[at - 3]) for each in found for at in range(4))
        return [(*begin, *end) for begin, end in pairs]

    def _places(self, found: Any, lens: Lens) -> Iterable[rtkit.Marker]:
        for each in found:
            yield rtkit.Marker(
                each.pose, id=str(each.id), type="fiducial", size=self.size,
                variance=lens.variance(each.far, self.size),
            )  # fmt: skip


def _polar(ray: Sequence[float]) -> tuple[float, float, float]:
    """Return a direction, of length 1, as a place that is endlessly far: range, bearing, height."""
    return math.inf, math.atan2(ray[1], ray[0]), math.asin(max(-1.0, min(1.0, ray[2])))


def _placed(marker: rtkit.Marker, pose: Pose, frame: str) -> rtkit.Marker:
    """Return a marker of a camera in the frame in which that has a pose.

    Of a mere direction it also has ``origin``, the place of the camera in that frame.
    """
    if marker.location is not None:
        return moved(marker, pose, frame)
    _, bearing, height = marker.features["polar"]
    level = math.cos(height)
    ray = (level * math.cos(bearing), level * math.sin(bearing), math.sin(height))
    turned = transform((0.0, 0.0, 0.0, *pose[3:]), ray)
    return marker.with_(frame=frame, polar=_polar(turned), origin=pose[:3])


def _outlined(picture: Picture, outlines: list[Any]) -> Picture:
    drawn: Picture = opencv().polylines(picture.copy(), outlines, True, (0, 255, 255), 2)
    return drawn


METHODS: dict[str, type[Method]] = {
    "edges": EdgeMethod,
    "blobs": BlobMethod,
    "fiducials": FiducialMethod,
}


_SOURCE = ("image.source",)


class Vision(Sensor, rtkit.Names):
    """Vision of one camera or several.

    Args:
        source: Property of another service that holds the picture of the only camera,
            ``robots/r1.camera.image``; empty: a picture is SET.
        cameras: Names and sources of several cameras instead: ``((left a.image) (right b.image))``.
        active: Methods that are active from the beginning.
        rate: How often a source is asked at most [Hz].
        field: Angle from the left to the right of pictures [rad].
        location, base, frames: See `Sensor`; a single camera is at the location.

    Attributes:
        cameras: Cameras by name: `source`, `location`, `field`, `image`.
        camera: Name of the camera whose picture `image` is.
        methods: Methods by name: `active`, `result`, and settings.

    Besides there is ``image.source``, the property of another service whose picture is processed.
    """

    type: Final[tuple[str, ...]] = ("vision", "sensor")  # type: ignore[misc]

    def __init__(
        self,
        source: str = "",
        cameras: tuple[tuple[str, str], ...] = (),
        active: tuple[str, ...] = (),
        rate: Annotated[float, rtkit.Unit("Hz")] = 10.0,
        field: Annotated[float, rtkit.Unit("rad")] = 1.2,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
    ) -> None:
        super().__init__(location, base, frames)
        opencv()
        active = (active,) if isinstance(active, str) else active
        if unknown := set(active) - METHODS.keys():
            raise ValueError(f"no method {min(unknown)} (there is {' '.join(METHODS)})")
        if any(isinstance(each, str) or len(each) != 2 for each in cameras):
            raise ValueError("cameras are names and sources, ((left a.image) (right b.image))")
        named = dict(cameras) if cameras else {"camera": source}
        self._stores = {
            name: PictureStore(self._picture_of, each, 1 / within("rate", rate, 1e-3))
            for name, each in named.items()
        }
        self.rate: Final[Annotated[float, rtkit.Unit("Hz")]] = rate  # type: ignore[misc]
        self.cameras: Final[dict[str, CameraView]] = {
            name: CameraView(each, within("field", field, 0.01, 3))
            for name, each in self._stores.items()
        }
        self.camera: Annotated[str, rtkit.Choices("cameras")] = next(iter(named))
        self.methods: Final[dict[str, Method]] = {
            name: each(self._chosen, self.get_location) for name, each in METHODS.items()
        }
        for name in active:
            self.methods[name].active = True

    def get_image(self, format: str = "jpeg", width: int = 0, camera: str = "") -> bytes:
        """The picture of a camera, as jpeg or png; 0 leaves its width as it is."""
        return self._chosen(camera)[1].get_image(format, width)

    def set_image(self, data: bytes) -> None:
        """Process this picture, a JPEG or PNG, in place of that of the camera."""
        self._chosen("")[2].put(data)

    def names(self) -> tuple[str, ...]:
        """See `rtkit.Names`: ``image.source``, the property whose picture is processed."""
        return _SOURCE

    def get(self, name: str) -> str:
        """See `rtkit.Names`."""
        return self._chosen("")[2].source

    def set(self, name: str, source: str) -> None:
        """See `rtkit.Names`: process the pictures of a property of another service."""
        if name not in _SOURCE:
            raise rtkit.PropertyError("unknown", f"no such property: {name}")
        self._chosen("")[2].source = source

    def has_changed(self) -> bool:
        """See `rtkit.Names`."""
        return False

    def get_data(self) -> bytes:
        """The picture of the camera."""
        return self.get_image()

    def get_markers(self, frame: str = "base") -> list[rtkit.Marker]:
        """All that the active methods find in the pictures of all cameras that are there."""
        self.get_location(frame)  # a frame that is not there is refused also when nothing is seen
        active = [each for each in self.methods.values() if each.active and "markers" in each.forms]
        found: list[rtkit.Marker] = []
        away: dict[str, rtkit.PropertyError] = {}
        for each, name in [(each, name) for each in active for name in self.cameras]:
            try:
                found += each.get_result("markers", name, frame=frame)
            except rtkit.PropertyError as error:
                away[name] = error
                if error.code == "bad-parameter" or len(away) == len(self.cameras):
                    raise
        status = f"waiting: {' '.join(away)}" if away else "ready"
        if status != self.status:
            self._publish("status", status)
        return found

    def _chosen(self, camera: str) -> Chosen:
        name = camera or self.camera
        if name not in self.cameras:
            raise rtkit.PropertyError("bad-parameter", f"no camera: {name}")
        return name, self.cameras[name], self._stores[name]

    def _picture_of(self, source: str) -> bytes:
        return self._asked().get_bytes(source)


VisionInit = init_of(Vision)
