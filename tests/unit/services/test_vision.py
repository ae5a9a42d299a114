"""Vision finds what is drawn: with noise, blur, rotation, occlusion and two cameras."""

from __future__ import annotations

import math
import struct
import threading
import time
import zlib
from functools import cache
from typing import Any

import cv2
import numpy as np
import pictures
import pytest
from pictures import FIELD, Picture

import rtkit
from rtkit.services import images, vision_methods
from rtkit.services.frames import ORIGIN, Frames, compose, inverse, transform
from rtkit.services.images import decode, encode, size_of
from rtkit.services.vision import PictureStore, Vision
from rtkit.world import Ball, Polygon, Scene, photo

HARD = [{}, {"noise": 10.0}, {"blur": 1.5}, {"noise": 20.0, "blur": 1.5}]
CAMERA = (0.2, -0.1, 0.5, 0.0, 0.1, 0.2)


def seen(picture: Picture, *active: str, **more: Any) -> Vision:
    vision = Vision(active=active, field=FIELD, **more)
    vision.set_image(encode(picture, "png"))
    return vision


# edges


@pytest.mark.parametrize("hard", HARD)
@pytest.mark.parametrize("turn", [0.1, 0.8, 2.3])
def test_segments_are_within_a_pixel(hard: dict[str, float], turn: float) -> None:
    corners = [
        (320 + r * math.cos(turn + at), 240 + r * math.sin(turn + at))
        for r, at in ((190, 0.0), (150, 1.4), (180, 3.2), (160, 4.9))
    ]
    fine = pictures.canvas()
    pictures.polygon(fine, corners, (40, 60, 50))
    found = np.array(
        seen(pictures.shown(fine, **hard), "edges").methods["edges"].get_result("segments")
    )
    ends = found.reshape(-1, 2, 2)
    taken = 0
    for begin, end in zip(corners, corners[1:] + corners[:1], strict=True):
        length = math.dist(begin, end)
        along = (np.array(end) - begin) / length
        off = np.abs((ends - begin) @ (-along[1], along[0])).max(1)
        own = off < 1.0
        parts = np.clip(np.sort((ends[own] - begin) @ along, 1), 0, length)
        assert (parts[:, 1] - parts[:, 0]).sum() > 0.95 * length
        taken += own.sum()
    assert taken == len(found)  # and nothing is found where nothing is


def test_a_hidden_edge_is_found_on_both_sides() -> None:
    fine = pictures.canvas()
    pictures.polygon(fine, [(100, 100), (540, 110), (540, 400), (100, 390)], (40, 40, 40))
    pictures.disc(fine, (320, 105), 40, (128, 128, 128))
    vision = seen(pictures.shown(fine, noise=10), "edges")
    vision.methods["edges"].least = 100.0  # type: ignore[attr-defined]
    top = [each for each in vision.methods["edges"].get_result("segments") if max(each[1::2]) < 115]
    assert len(top) == 2
    assert all(abs(y - (100 + (x - 100) / 44)) < 1 for each in top for x, y in (each[:2], each[2:]))


def test_the_result_is_a_picture_of_the_wanted_width() -> None:
    fine = pictures.canvas()
    pictures.polygon(fine, [(100, 100), (540, 110), (300, 400)], (40, 40, 40))
    edges = seen(pictures.shown(fine), "edges").methods["edges"]
    drawn = decode(edges.get_result("image", width=320))
    assert drawn.shape == (240, 320, 3)
    assert size_of(edges.get_result(format="jpeg", width=100)) == (100, 75)
    assert 0.001 < (drawn > 100).mean() < 0.05


# blobs


@pytest.mark.parametrize("hard", HARD)
def test_centres_are_within_two_pixels_also_of_what_is_hidden_in_part(
    hard: dict[str, float],
) -> None:
    fine = pictures.canvas()
    pictures.disc(fine, (200.3, 150.6), 40, (30, 30, 220))
    pictures.disc(fine, (450.7, 300.2), 25, (220, 60, 30))
    pictures.polygon(fine, [(70, 300), (170, 330), (140, 420), (60, 400)], (40, 200, 40))
    pictures.polygon(fine, [(218, 90), (300, 90), (300, 210), (218, 210)], (90, 90, 90))
    blobs = seen(pictures.shown(fine, **hard), "blobs").methods["blobs"].get_result()
    found = {each.name: each for each in blobs}
    assert len(blobs) == len(found) == 3
    truth = {"red": (200.3, 150.6), "blue": (450.7, 300.2), "green": _middle()}
    for name, place in truth.items():
        assert math.dist(found[name].features["pixel"], place) < 2, name
    assert [found[each].type for each in ("red", "blue", "green")] == ["ball", "ball", "blob"]
    assert found["red"].features["pixels"] == pytest.approx(80, abs=3)
    assert found["blue"].features["color"] == pytest.approx(
        (30 / 255, 60 / 255, 220 / 255), abs=0.1
    )


@pytest.mark.parametrize("hard", HARD)
@pytest.mark.parametrize("place", [(305.0, 101.6), (560.3, 300.2), (620.6, 240.2), (30.1, 470.4)])
def test_centres_are_within_two_pixels_at_the_rim_of_the_picture(
    hard: dict[str, float], place: tuple[float, float]
) -> None:
    fine = pictures.canvas()
    pictures.disc(fine, place, 85, (30, 220, 230))
    (blob,) = seen(pictures.shown(fine, **hard), "blobs").methods["blobs"].get_result()
    assert math.dist(blob.features["pixel"], place) < 2


def _middle() -> tuple[float, float]:
    moments = cv2.moments(np.array([(70, 300), (170, 330), (140, 420), (60, 400)], np.float32))
    return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]


@pytest.mark.parametrize("hard", HARD)
def test_a_ball_of_known_size_is_where_it_is(hard: dict[str, float]) -> None:
    center = (1.9, 0.5, 0.2)
    fine = pictures.canvas()
    pictures.ball(fine, CAMERA, center, 0.1, (30, 30, 220))
    vision = seen(pictures.shown(fine, **hard), "blobs", location=CAMERA)
    (direction,) = vision.get_markers()
    vision.methods["blobs"].diameter = 0.2  # type: ignore[attr-defined]
    (ball,) = vision.get_markers()
    far = math.dist(center, CAMERA[:3])
    assert math.dist(ball.location or (), center) < 0.03 * far
    assert math.dist(ball.location or (), center) < 3 * math.sqrt(ball.variance or 0)
    assert direction.location is None
    assert direction.features["origin"] == CAMERA[:3]
    endless, bearing, height = direction.features["polar"]
    away = [(a - b) / far for a, b in zip(center, CAMERA, strict=False)]
    assert (endless, bearing) == (math.inf, pytest.approx(math.atan2(away[1], away[0]), abs=0.01))
    assert height == pytest.approx(math.asin(away[2]), abs=0.01)


@pytest.mark.parametrize(
    ("eye", "center"),
    [((0.0, 0.0, 0.4, 0.3), (1.5, 0.2, 0.15)), ((1.0, -1.0, 0.3, 2.0), (0.5, 1.0, 0.1))],
)
def test_a_ball_of_the_simulated_world_is_where_it_is(
    eye: tuple[float, ...], center: tuple[float, float, float]
) -> None:
    wall = [(-4, -4), (4, -4), (4, 4), (-4, 4)]
    outer = [(-5, -5), (5, -5), (5, 5), (-5, 5)]
    shown = photo(Scene([Polygon(outer, [wall])]), eye, [Ball(center, 0.1, (0.9, 0.1, 0.1))])
    vision = Vision(active=("blobs",), location=(*eye[:3], 0.0, 0.0, eye[3]))
    vision.methods["blobs"].diameter = 0.2  # type: ignore[attr-defined]
    vision.methods["blobs"].colors = ("red",)  # type: ignore[attr-defined]
    vision.set_image(encode(np.ascontiguousarray(shown[:, :, ::-1]), "png"))
    (ball,) = vision.get_markers()
    assert math.dist(ball.location or (), center) < 0.03 * math.dist(center, eye[:3])


# fiducials

FACES = (0.0, 0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2)
"""Pose of a plate that is looked at from behind x."""


def plate(place: tuple[float, ...], yaw: float, pitch: float, roll: float) -> tuple[float, ...]:
    turned = compose((*place, 0.0, pitch, yaw), FACES)
    return compose(turned, (0, 0, 0, 0, 0, roll))


PLATES = {
    3: plate((2.0, 0.3, 0.4), 0.3, 0.2, 0.2),
    4: plate((2.2, -0.3, 0.5), -0.5, 0.2, 0.9),
    5: plate((2.4, 0.9, 0.1), 0.6, -0.1, -1.0),
}


@cache
def plates_seen(camera: tuple[float, ...]) -> Picture:
    fine = pictures.canvas()
    for id, pose in PLATES.items():
        pictures.fiducial(fine, camera, pose, id, 0.3)
    return fine


def scene(camera: tuple[float, ...], **hard: float) -> Picture:
    return pictures.shown(plates_seen(camera), **hard)


def check(marker: rtkit.Marker, camera: tuple[float, ...]) -> None:
    truth = PLATES[int(marker.id)]
    far = math.dist(truth[:3], camera[:3])
    assert math.dist((marker.location or ())[:3], truth[:3]) < 0.03 * far
    turned = compose(inverse(truth), marker.location or ())[3:]
    assert math.hypot(*turned) < 0.03 * math.pi


@pytest.mark.parametrize("hard", HARD)
def test_the_pose_of_fiducials_is_within_three_percent(hard: dict[str, float]) -> None:
    vision = seen(scene(CAMERA, **hard), "fiducials", location=CAMERA)
    vision.methods["fiducials"].size = 0.3  # type: ignore[attr-defined]
    found = vision.get_markers()
    assert [each.id for each in found] == ["3", "4", "5"]
    for each in found:
        check(each, CAMERA)
    sides = vision.methods["fiducials"].get_result("segments")
    assert len(sides) == 12


@pytest.mark.parametrize("hidden", PLATES)
def test_a_fiducial_that_is_hidden_in_part_is_no_other_and_nowhere_else(hidden: int) -> None:
    pose, found = PLATES[hidden], 0
    for x, y in ((0.0, 0.06), (-0.15, 0.15), (0.15, 0.15), (0.15, -0.15), (-0.15, -0.15)):
        middle = pictures.projected(CAMERA, transform(pose, (x, y, 0.0)))
        for radius, color in ((6, (60, 120, 60)), (7, (0, 0, 0)), (9, (255, 255, 255))):
            fine = plates_seen(CAMERA).copy()
            pictures.disc(fine, middle, radius, color)
            vision = seen(pictures.shown(fine, noise=5), "fiducials", location=CAMERA)
            vision.methods["fiducials"].size = 0.3  # type: ignore[attr-defined]
            markers = {each.id: each for each in vision.get_markers()}
            assert {*map(str, PLATES)} - {str(hidden)} <= markers.keys() <= {*map(str, PLATES)}
            for marker in markers.values():
                check(marker, CAMERA)
            found += str(hidden) in markers
    assert 0 < found < 15


def test_two_cameras_see_the_same_things_at_the_same_places() -> None:
    views = {"left": (0.0, 0.35, 0.1, 0.0, 0.05, -0.1), "right": (0.1, -0.35, 0.0, 0.05, 0.0, 0.25)}
    base = (4.0, -2.0, 0.0, 0.0, 0.0, 2.0)
    mount = (0.1, 0.0, 0.5, 0.0, 0.0, 0.1)
    vision = Vision(
        cameras=tuple((each, "") for each in views), active=("fiducials",), field=FIELD,
        location=mount, frames=Frames(base=lambda: base),
    )  # fmt: skip
    vision.methods["fiducials"].size = 0.3  # type: ignore[attr-defined]
    for name, view in views.items():
        camera = compose(mount, view)
        vision.cameras[name].location = view
        vision.cameras[name].set_image(encode(scene(camera, noise=5), "png"))
    found = vision.get_markers()
    assert {(each.features["camera"], each.id) for each in found} >= {
        (name, id) for name in views for id in ("3", "4")
    }
    for each in found:
        check(each, compose(mount, views[each.features["camera"]]))
    for own, far in zip(found, vision.get_markers("world"), strict=True):
        assert far.frame == "world"
        assert far.location == pytest.approx(transform(base, own.location or ()))


# what it costs


def test_an_inactive_method_computes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    called = []
    for name in ("segments", "edge_picture", "blobs", "fiducials"):
        plain = getattr(vision_methods, name)
        monkeypatch.setattr(
            vision_methods, name, lambda *args, n=name, f=plain: (called.append(n), f(*args))[1]
        )
    vision = seen(pictures.shown(pictures.canvas()), "blobs")
    for _ in range(3):
        vision.get_markers()
    assert called == ["blobs"]  # once for a picture, however often it is asked for
    with pytest.raises(rtkit.PropertyError, match="not active") as refused:
        vision.methods["edges"].get_result()
    assert refused.value.code == "conflict"
    assert called == ["blobs"]
    vision.methods["fiducials"].active = True
    vision.methods["blobs"].active = False
    vision.get_markers()
    vision.methods["edges"].active = True
    vision.methods["edges"].get_result("segments")
    assert called == ["blobs", "fiducials", "segments"]
    vision.methods["edges"].least = 99.0  # type: ignore[attr-defined]
    vision.methods["edges"].get_result("segments")
    assert [each.runs for each in vision.methods.values()] == [2, 1, 1]
    assert vision.methods["edges"].seconds > 0
    vision.set_image(encode(pictures.shown(pictures.canvas(), noise=3), "jpeg"))
    vision.get_markers()
    assert [each.runs for each in vision.methods.values()] == [2, 1, 2]


def test_a_source_that_is_silent_is_not_asked_by_each_who_waits() -> None:
    asked = []

    def silent(source: str) -> bytes:
        asked.append(source)
        time.sleep(0.05)
        raise rtkit.PropertyError("timeout", "no answer")

    store = PictureStore(silent, "camera.image", age=10.0)
    codes = []

    def look() -> None:
        with pytest.raises(rtkit.PropertyError) as refused:
            store.latest()
        codes.append(refused.value.code)

    waiting = [threading.Thread(target=look) for _ in range(9)]
    for each in waiting:
        each.start()
    for each in waiting:
        each.join()
    assert (codes, asked) == (["timeout"] * 9, ["camera.image"])
    store.put(encode(PLAIN, "png"))
    assert store.latest()[1].shape == PLAIN.shape


# pictures in and out


@pytest.mark.parametrize(("format", "head"), [("jpeg", b"\xff\xd8"), ("png", b"\x89PNG")])
def test_pictures_come_out_in_the_wanted_format_and_width(format: str, head: bytes) -> None:
    vision = seen(pictures.shown(pictures.canvas()))
    data = vision.get_image(format, 200)
    assert data.startswith(head)
    assert size_of(data) == (200, 150)
    assert size_of(vision.get_image(format)) == (640, 480)


@pytest.mark.parametrize(
    ("format", "width"), [("gif", 0), ("jpeg", -5), ("png", 10_000_000), ("", 1)]
)
def test_no_such_picture_can_be_had(format: str, width: int) -> None:
    with pytest.raises(rtkit.PropertyError) as refused:
        seen(pictures.shown(pictures.canvas())).get_image(format, width)
    assert refused.value.code == "bad-parameter"


def bomb(width: int, height: int) -> bytes:
    """Return a PNG that is small and says that it is large."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(bytes(1000))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def test_a_huge_picture_is_refused_by_its_head(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cv2, "imdecode", lambda *args: pytest.fail("it is decoded"))
    large = b"\xff\xd8\xff\xe0\x00\x04ab\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03" + bytes(20)
    for data in (bomb(100_000, 100_000), large):
        with pytest.raises(rtkit.PropertyError, match="pixels, more than") as refused:
            decode(data)
        assert refused.value.code == "too-large"


PLAIN = pictures.shown(pictures.canvas(), noise=20)


RUBBISH = {
    "nothing": b"", "text": b"rubbish", "jpeg": b"\xff\xd8", "one more": b"\xff\xd8\xff",
    "fill": b"\xff\xd8" + b"\xff" * 50, "png": b"\x89PNG\r\n\x1a\n", "no end": bomb(640, 480)[:-12],
    "cut jpeg": encode(PLAIN, "jpeg")[:-9000], "cut png": encode(PLAIN, "png")[:-9000],
    "no length": b"\xff\xd8\xff\xe0\0\0" * 9, "no size": bomb(0, 480),
}  # fmt: skip


@pytest.mark.parametrize("data", RUBBISH.values(), ids=RUBBISH.keys())
def test_rubbish_is_refused_and_the_last_picture_stays(data: bytes) -> None:
    vision = seen(PLAIN)
    with pytest.raises(rtkit.PropertyError) as refused:
        vision.set_image(data)
    assert refused.value.code == "bad-value"
    assert size_of(vision.get_image()) == (640, 480)


def test_what_is_not_there_is_told() -> None:
    vision = Vision(active=("edges",))
    for ask in (vision.get_image, vision.methods["edges"].get_result):
        with pytest.raises(rtkit.PropertyError, match="no picture yet") as refused:
            ask()
        assert refused.value.code == "no-service"
    vision.set_image(encode(PLAIN, "png"))
    for wrong in ({"form": "markers"}, {"camera": "rear"}):
        with pytest.raises(rtkit.PropertyError) as refused:
            vision.methods["edges"].get_result(**wrong)
        assert refused.value.code == "bad-parameter"
    vision.methods["fiducials"].active = True
    vision.methods["fiducials"].dictionary = "9x9"  # type: ignore[attr-defined]
    with pytest.raises(rtkit.PropertyError, match="no dictionary"):
        vision.get_markers()
    with pytest.raises(ValueError, match="no method lines"):
        Vision(active=("lines",))
    with pytest.raises(ValueError, match="names and sources"):
        Vision(cameras=("left", "right"))  # type: ignore[arg-type]
    assert Vision(active="edges").methods["edges"].active  # type: ignore[arg-type]


def test_without_opencv_it_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "cv2", None)
    with pytest.raises(Exception, match=r"pip install 'rtkit\[vision\]'"):
        images.opencv()
    with pytest.raises(Exception, match=r"pip install 'rtkit\[vision\]'"):
        Vision()
    assert ORIGIN
