"""Methods of vision: edges, colour blobs, fiducials. Each takes a picture, and knows no service."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import rtkit
from rtkit.services.frames import angles_of
from rtkit.services.images import opencv

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rtkit.services.images import Picture

    Segments = NDArray[np.float64]
    """A row ``x1 y1 x2 y2`` for each [pixels]; the first pixel has its middle at 0."""

Color = Literal["red", "orange", "yellow", "green", "cyan", "blue", "purple", "pink"]
HUES: Mapping[Color, tuple[int, int]] = {
    "red": (170, 10), "orange": (11, 22), "yellow": (23, 34), "green": (35, 85),
    "cyan": (86, 97), "blue": (98, 130), "purple": (131, 150), "pink": (151, 169),
}  # fmt: skip
"""Range of each colour's hue, as OpenCV counts it: 0 to 179; red lies round its ends."""
_LEAST_SATURATION, _LEAST_VALUE = 90, 50
_PIXEL_ERROR = 0.5
"""Standard deviation of a place in a picture [pixels]."""
_MISFIT, _MISFIT_SHARE = 0.3, 0.004
"""How far the corners of a mark may be from those of a square [pixels; of its side]."""
_TRIALS = 60
_LEAST_CONTRAST = 30.0
_LEAST_RIM = 9
"""Points of a rim that may tell a circle."""


class Lens(NamedTuple):
    """Pinhole through which a picture was taken: focal length and middle [pixels]."""

    focal: float
    x: float
    y: float

    @classmethod
    def of(cls, picture: Picture, field: float) -> Lens:
        """Return the lens of a picture that is so wide an angle [rad]."""
        height, width = picture.shape[:2]
        return cls(width / 2 / math.tan(field / 2), (width - 1) / 2, (height - 1) / 2)

    def ray(self, x: float, y: float) -> tuple[float, float, float]:
        """Return the direction in which a pixel looks, of length 1: ahead, left, up."""
        left, up = (self.x - x) / self.focal, (self.y - y) / self.focal
        length = math.sqrt(1 + left * left + up * up)
        return 1 / length, left / length, up / length

    def variance(self, far: float, size: float) -> float:
        """Return how sure a distance is that was told from a size in the picture [m²]."""
        return (far * far * _PIXEL_ERROR / (self.focal * size)) ** 2


def segments(picture: Picture, smooth: float, least: float) -> Segments:
    """Return the straight edges.

    Args:
        picture: Where they are looked for.
        smooth: How much noise is smoothed away first [pixels]; 0 for not at all.
        least: Length of the shortest one [pixels].
    """
    cv2 = opencv()
    import numpy as np

    found = cv2.createLineSegmentDetector().detect(_grey(picture, smooth))[0]
    rows = np.zeros((0, 4)) if found is None else found.reshape(-1, 4).astype(np.float64)
    kept: Segments = rows[np.hypot(rows[:, 2] - rows[:, 0], rows[:, 3] - rows[:, 1]) >= least]
    return kept


def edge_picture(picture: Picture, smooth: float, threshold: float) -> Picture:
    """Return a picture that is white where edges are, however bent."""
    edges: Picture = opencv().Canny(_grey(picture, smooth), threshold / 2, threshold)
    return edges


def _grey(picture: Picture, smooth: float) -> Picture:
    cv2 = opencv()
    grey: Picture = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    return cv2.GaussianBlur(grey, (0, 0), smooth) if smooth else grey


class Blob(NamedTuple):
    """Area of one colour.

    Attributes:
        color: Its name.
        center: Of the circle round it where it is, or was, a disc; else of its area [pixels].
        diameter: Likewise [pixels].
        is_disc: Whether most of its rim lies on a circle: then it may be hidden in part.
        rgb: Mean colour, 0 to 1.
        outline: Its rim [pixels].
    """

    color: str
    center: tuple[float, float]
    diameter: float
    is_disc: bool
    rgb: tuple[float, float, float]
    outline: Any


def blobs(picture: Picture, colors: tuple[Color, ...], least: float) -> list[Blob]:
    """Return the areas of some colours, the largest of each colour first.

    Args:
        picture: Where they are looked for.
        colors: Names, of `HUES`.
        least: Area of the smallest one [pixels].
    """
    cv2 = opencv()
    import numpy as np

    hsv = cv2.cvtColor(cv2.GaussianBlur(picture, (0, 0), 1.2), cv2.COLOR_BGR2HSV)
    found = []
    for color in colors:
        low, high = HUES[color]
        ranges = [(low, high)] if low <= high else [(low, 179), (0, high)]
        floor = (_LEAST_SATURATION, _LEAST_VALUE)
        masks = [cv2.inRange(hsv, (a, *floor), (b, 255, 255)) for a, b in ranges]
        mask = cv2.morphologyEx(
            np.bitwise_or.reduce(masks), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)
        )
        rims = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        large = [each for each in rims if cv2.contourArea(each) >= least]
        large.sort(key=cv2.contourArea, reverse=True)
        found += [_blob(picture, color, rim) for rim in large]
    return found


def _blob(picture: Picture, color: str, rim: Any) -> Blob:
    cv2 = opencv()
    import numpy as np

    mask = np.zeros(picture.shape[:2], np.uint8)
    cv2.drawContours(mask, [rim], -1, 255, cv2.FILLED)
    blue, green, red = (round(each / 255, 3) for each in cv2.mean(picture, mask)[:3])
    circle = _circle(picture, rim.reshape(-1, 2).astype(np.float64))
    if circle is not None:
        x, y, radius = circle
        return Blob(color, (x, y), 2 * radius, True, (red, green, blue), rim)
    moments = cv2.moments(mask, binaryImage=True)
    x, y = moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
    return Blob(
        color, (x, y), 2 * math.sqrt(moments["m00"] / math.pi), False, (red, green, blue), rim
    )


def _circle(picture: Picture, rim: Any) -> tuple[float, float, float] | None:
    """Return the circle (x y radius) on which most of a rim lies, None if there is none.

    Three points make a circle. A thing that hides a disc takes something away: nothing is out of
    it.
    """
    import numpy as np

    height, width = picture.shape[:2]
    is_inside = (rim > 0).all(1) & (rim < (width - 1, height - 1)).all(1)
    rim = rim[is_inside]  # the picture's own rim hides what is beyond
    if len(rim) < _LEAST_RIM:
        return None
    chance = np.random.default_rng(1)
    best, most, extent = None, 0.55 * len(rim), float(np.ptp(rim, 0).max())
    for _ in range(_TRIALS):
        fitted = _fit(rim[chance.choice(len(rim), 3, replace=False)])
        for _ in range(2):
            near = np.abs(_off(rim, fitted)) < 2 * _tolerance(fitted)
            fitted = _fit(rim[near]) if near.sum() >= _LEAST_RIM else fitted
        off = _off(rim, fitted)
        near = np.abs(off) < _tolerance(fitted)
        is_within = (off > 2 * _tolerance(fitted)).mean() < 0.02
        if fitted[2] < extent and near.sum() > most and is_within:
            best, most = near, near.sum()
    if best is None:
        return None
    fitted = _fit(rim[best])
    edge = _edge(picture, fitted, rim[best])
    if len(edge) >= _LEAST_RIM:
        near = np.abs(_off(edge, _fit(edge))) < _tolerance(fitted)
        fitted = _fit(edge[near]) if near.sum() >= _LEAST_RIM else fitted
    x, y, radius = map(float, fitted)
    return x, y, radius


def _edge(picture: Picture, circle: Any, rim: Any) -> Any:
    """Return where a circle ends, to parts of a pixel: half way from one colour to the other."""
    cv2 = opencv()
    import numpy as np

    x, y, radius = circle
    steps = np.linspace(0.6, 1.4, 49) * radius
    turns = np.arctan2(rim[:, 1] - y, rim[:, 0] - x)[:: max(1, len(rim) // 180), None]
    places = (x + steps * np.cos(turns), y + steps * np.sin(turns))
    columns, rows = (each.astype(np.float32) for each in places)
    border = cv2.BORDER_REPLICATE  # what is out of the picture is as its rim
    rays = cv2.remap(picture, columns, rows, cv2.INTER_LINEAR, borderMode=border).astype(np.float64)
    own, other = rays[:, :15].mean(1)[:, None], rays[:, -10:].mean(1)[:, None]
    axis = own - other
    length = (axis * axis).sum(2)
    share = ((rays - other) * axis).sum(2) / np.maximum(length, 1.0)
    ends = steps[0] + (np.clip(share, 0, 1).sum(1) - 0.5) * (steps[1] - steps[0])
    seen = np.column_stack((x + ends * np.cos(turns[:, 0]), y + ends * np.sin(turns[:, 0])))
    return seen[length[:, 0] > _LEAST_CONTRAST**2]


def _off(rim: Any, circle: Any) -> Any:
    """Return how far points are out of a circle [pixels]."""
    import numpy as np

    return np.hypot(rim[:, 0] - circle[0], rim[:, 1] - circle[1]) - circle[2]


def _tolerance(circle: Any) -> float:
    return max(1.0, 0.025 * float(circle[2]))


def _fit(points: Any) -> Any:
    """Return x, y and radius of the circle that is next to points, by least squares."""
    import numpy as np

    system = np.column_stack((2 * points, np.ones(len(points))))
    x, y, rest = np.linalg.lstsq(system, (points**2).sum(1), rcond=None)[0]
    return np.array((x, y, math.sqrt(max(0.0, rest + x * x + y * y))))


class Fiducial(NamedTuple):
    """Square mark with a number.

    Attributes:
        id: Its number.
        corners: From its upper left one, clockwise as it is drawn [pixels].
        pose: In the frame of the camera; its x is to its right, y up, z out of it [m, rad].
        far: Distance [m].
    """

    id: int
    corners: Any
    pose: tuple[float, ...]
    far: float


def dictionaries() -> list[str]:
    """Return the names of the dictionaries of marks that there are."""
    names = [each for each in dir(opencv().aruco) if each.startswith("DICT_") and each.isupper()]
    return [each.removeprefix("DICT_").lower() for each in names]


def fiducials(picture: Picture, lens: Lens, size: float, dictionary: str) -> list[Fiducial]:
    """Return the ArUco marks in a picture, but those whose corners fit no square.

    Args:
        picture: Where they are looked for.
        lens: Through which it was taken.
        size: Side of the black square [m].
        dictionary: Of marks, as OpenCV names it: ``4x4_50`` …

    Raises:
        PropertyError: ``bad-value``: there is no such dictionary.
    """
    cv2 = opencv()
    import numpy as np

    if dictionary not in dictionaries():
        raise rtkit.PropertyError("bad-value", f"no dictionary of fiducials: {dictionary}")
    words = getattr(cv2.aruco, f"DICT_{dictionary.upper()}")
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(words), settings)
    corners, ids, _ = detector.detectMarkers(picture)
    half = size / 2
    square = np.array([(-half, half, 0), (half, half, 0), (half, -half, 0), (-half, -half, 0)])
    camera = np.array([(lens.focal, 0, lens.x), (0, lens.focal, lens.y), (0, 0, 1.0)])
    found = []
    for id, seen in zip(() if ids is None else ids.ravel(), corners, strict=True):
        _, turns, shifts, misfits = cv2.solvePnPGeneric(
            square, seen.reshape(4, 2).astype(np.float64), camera, None,
            flags=cv2.SOLVEPNP_IPPE_SQUARE,
        )  # fmt: skip
        side = cv2.arcLength(seen.reshape(4, 1, 2), closed=True) / 4
        if misfits.ravel()[0] > max(_MISFIT, _MISFIT_SHARE * side):
            continue  # a corner is hidden: what is seen of it is elsewhere
        pose = _pose(cv2.Rodrigues(turns[0])[0], shifts[0].ravel())
        found.append(Fiducial(int(id), seen.reshape(4, 2), pose, float(np.linalg.norm(shifts[0]))))
    return sorted(found, key=lambda each: each.id)


def _pose(turn: Any, shift: Any) -> tuple[float, ...]:
    """Return what OpenCV sees (x right, y down, z ahead) as a pose with x ahead and z up."""
    right, down, ahead = shift
    rows = (turn[2], -turn[0], -turn[1])
    return tuple(map(float, (ahead, -right, -down, *angles_of(rows))))
