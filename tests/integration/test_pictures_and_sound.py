"""Cameras, vision by reference, and microphones over their endpoints."""

from __future__ import annotations

import math
import os
import shutil
import struct
import threading
import wave
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue

import numpy as np
import pictures
import pytest
from waiting import until

import rtkit
from rtkit.services.camera import Camera
from rtkit.services.frames import transform
from rtkit.services.images import decode, encode, size_of
from rtkit.services.microphone import Microphone
from rtkit.services.vision import Vision
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import serve

BOUND_S = 10.0


@pytest.fixture
def client(place: str) -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=BOUND_S) as client:
        yield client


def picture(x: float) -> bytes:
    fine = pictures.canvas()
    pictures.disc(fine, (x, 200), 40, (30, 30, 220))
    return encode(pictures.shown(fine), "png")


def at(client: rtkit.Client, service: str = "vision") -> float:
    (marker,) = client.get(f"{service}.markers")
    return float(marker.features["pixel"][0])


# cameras


def test_a_camera_shows_a_folder_and_waits_while_it_is_away(
    client: rtkit.Client, place: str
) -> None:
    camera = Camera(f"{place}/shots", rate=50)
    with serve(camera, "camera", is_on_zenoh=False):
        until(lambda: "No such file" in client.get("camera.status"), "it waits")
        with pytest.raises(rtkit.PropertyError, match="no picture: waiting") as refused:
            client.get("camera.image")
        assert refused.value.code == "no-service"
        os.mkdir(f"{place}/new")
        for each in range(3):
            Path(f"{place}/new/{each}.png").write_bytes(picture(100 + 100 * each))
        os.rename(f"{place}/new", f"{place}/shots")
        until(lambda: client.get("camera.status") == "ready", "it shows them")
        seen = threading.Event()
        found = set()

        def look(change: rtkit.PropertyChange) -> None:
            if isinstance(change.value, bytes):
                found.add(change.value)
                if len(found) == 3:
                    seen.set()

        with client.listen("camera.image", look):
            assert seen.wait(BOUND_S)
        assert size_of(client.get("camera.image", format="png", width=64)) == (64, 48)
        Path(f"{place}/shots/1.png").write_bytes(b"damaged")
        until(lambda: "no JPEG or PNG" in client.get("camera.status"), "what is wrong is told")
        shutil.rmtree(f"{place}/shots")
        until(lambda: "No such file" in client.get("camera.status"), "it waits again")


def test_a_video_is_shown(client: rtkit.Client, place: str) -> None:
    import cv2

    film = cv2.VideoWriter(f"{place}/film.avi", cv2.VideoWriter.fourcc(*"MJPG"), 25, (640, 480))
    film.write(decode(picture(320)))
    film.release()
    with serve(Camera(f"{place}/film.avi", rate=50), "camera", is_on_zenoh=False):
        until(lambda: client.get("camera.status") == "ready", "it is open")
        assert size_of(client.get("camera.image")) == (640, 480)


def test_a_camera_that_falls_silent_has_no_picture_until_one_comes(
    client: rtkit.Client, place: str
) -> None:
    import cv2

    film = cv2.VideoWriter(f"{place}/film.avi", cv2.VideoWriter.fourcc(*"MJPG"), 25, (64, 48))
    for each in range(200):
        film.write(np.full((48, 64, 3), each, np.uint8))
    film.release()
    recorded = Path(f"{place}/film.avi").read_bytes()
    half = len(recorded) // 2
    os.mkfifo(f"{place}/live.avi")
    camera = Camera(f"{place}/live.avi", rate=1000, silence=0.25)
    served = serve(camera, "camera", is_on_zenoh=False)
    with open(f"{place}/live.avi", "wb", buffering=0) as pipe, served:  # which ends first
        pipe.write(recorded[:half])
        until(lambda: client.get("camera.status").startswith("silent since 2"), "it says so")
        with pytest.raises(rtkit.PropertyError, match="no picture: silent since") as refused:
            client.get("camera.image")
        assert refused.value.code == "no-service"
        with client.listen("camera.status", (heard := SimpleQueue()).put):
            assert heard.get(timeout=BOUND_S).value.startswith("silent")
            pipe.write(recorded[half : half + 2000])
            assert heard.get(timeout=BOUND_S).value == "ready"
            assert heard.get(timeout=BOUND_S).value.startswith("silent")


def test_a_simulated_camera_looks_when_it_is_asked(client: rtkit.Client) -> None:
    looks = []

    def look() -> object:
        looks.append(1)
        return np.full((30, 40, 3), (250, 0, 0), np.uint8)

    with serve(Camera(look=look, rate=0.5), "camera", is_on_zenoh=False):
        assert looks == []
        red = decode(client.get("camera.image", format="png"))
        client.get("camera.image")
        assert tuple(red[0, 0]) == (0, 0, 250)  # blue, green, red
        assert looks == [1]


# vision


def test_vision_processes_the_pictures_of_another_service(client: rtkit.Client) -> None:
    class Eye:
        image: bytes = picture(100)

    eye = Eye()
    with serve(Vision(active=("blobs",), rate=1000), "vision", is_on_zenoh=False):
        client.set("vision.image.source", '"robots/r1/eye.image"')
        with pytest.raises(rtkit.PropertyError) as refused:
            client.get("vision.markers")
        assert refused.value.code == "no-service"
        with serve(eye, "robots/r1/eye", is_on_zenoh=False):
            until(lambda: _code(client, "vision.markers") == "", "the failure is old enough")
            assert at(client) == pytest.approx(100, abs=1)
            eye.image = picture(400)
            until(lambda: abs(at(client) - 400) < 1, "it follows")
            grain = np.random.default_rng(1).integers(0, 99, (900, 1200, 3)).astype(np.uint8)
            eye.image = encode(grain, "png")
            assert len(eye.image) > 2_000_000  # more than one message holds
            until(lambda: size_of(client.get("vision.image")) == (1200, 900), "it follows")
            eye.image = b"\xff\xd8 damaged"
            until(lambda: _code(client, "vision.markers") == "bad-value", "it says so")
        until(lambda: _code(client, "vision.markers") == "no-service", "its source has gone")
        client.set_bytes("vision.image", picture(250))
        assert at(client) == pytest.approx(250, abs=1)
        assert client.get("vision.image.source") == ""


def test_two_cameras_see_one_mark_at_one_place_and_one_sees_on_alone(
    client: rtkit.Client,
) -> None:
    """By reference to their services, in the world's frame, by their own poses."""
    base = (4.0, -2.0, 0.0, 0.0, 0.0, 2.0)
    views = {"left": (0.0, 0.35, 0.1, 0.0, 0.05, -0.1), "right": (0.1, -0.35, 0, 0.05, 0, 0.25)}
    plate = (2.4, 0.1, 0.2, math.pi / 2, 0.0, 0.2 - math.pi / 2)  # as the vision service sees it

    class Base:
        location = base

    def served(name: str) -> object:
        fine = pictures.canvas()
        pictures.fiducial(fine, views[name], plate, 7, 0.3)
        seen = pictures.shown(fine, noise=4)[:, :, ::-1]
        return serve(Camera(look=lambda: seen), f"b/{name}", is_on_zenoh=False)

    sources = tuple((name, f"b/{name}.image") for name in views)
    vision = Vision(
        cameras=sources, active=("fiducials",), rate=1000, field=pictures.FIELD, base="b"
    )
    with serve(Base(), "b", is_on_zenoh=False), serve(vision, "vision", is_on_zenoh=False):
        for name, view in views.items():
            client.set(f"vision.cameras.{name}.location", view)
        client.set("vision.methods.fiducials.size", 0.3)
        left, right = served("left"), served("right")
        found = client.get("vision.markers", frame="world")
        assert [each.features["camera"] for each in found] == ["left", "right"]
        truth = transform(base, plate[:3])
        for each in found:
            assert math.dist(each.location[:3], truth) < 0.03 * 2.4
        assert client.get("vision.status") == "ready"
        left.close()  # type: ignore[attr-defined]
        until(lambda: len(client.get("vision.markers")) == 1, "the other sees on")
        (alone,) = client.get("vision.markers", frame="world")
        assert alone.features["camera"] == "right"
        assert client.get("vision.status") == "waiting: left"
        right.close()  # type: ignore[attr-defined]
        until(lambda: _code(client, "vision.markers") != "", "none is there")
        with served("left"), served("right"):  # type: ignore[attr-defined]
            until(lambda: _code(client, "vision.markers") == "", "one is back")
            until(lambda: len(client.get("vision.markers")) == 2, "both are back")
            assert client.get("vision.status") == "ready"


def _code(client: rtkit.Client, target: str) -> str:
    try:
        client.get(target)
    except rtkit.PropertyError as error:
        return error.code
    return ""


def test_methods_are_switched_one_by_one_and_run_together(client: rtkit.Client) -> None:
    with serve(Vision(), "vision", is_on_zenoh=False):
        client.set_bytes("vision.image", picture(320))
        assert client.get("vision.methods") == ("edges", "blobs", "fiducials")
        assert client.get("vision.cameras") == ("camera",)
        assert client.get("vision.markers") == ()
        kinds = [client.get(f"vision.methods.{each}.result.gui").attributes["kind"]
                 for each in ("edges", "blobs", "fiducials")]  # fmt: skip
        assert kinds == ["image", "map", "map"]
        for name in ("edges", "blobs"):
            client.set(f"vision.methods.{name}.active", "true")
        assert size_of(client.get("vision.methods.edges.result", form="image")) == (640, 480)
        segments = client.get("vision.methods.edges.result", form="segments")
        assert all(len(each) == 4 for each in segments)
        assert at(client) == pytest.approx(320, abs=1)
        (blob,) = client.get("vision.methods.blobs.result")
        assert blob.name == "red"
        with pytest.raises(rtkit.PropertyError, match="crimson"):
            client.set("vision.methods.blobs.colors", ("red", "crimson"))
        assert len(client.get("vision.methods.blobs.colors")) == 8
        assert client.get("vision.methods.fiducials.runs") == 0
        client.set("vision.methods.blobs.active", "false")
        assert client.get("vision.markers") == ()
        assert _code(client, "vision.methods.blobs.result") == "conflict"
        with pytest.raises(rtkit.PropertyError) as refused:
            client.set_bytes("vision.image", picture(320)[:-500])
        assert refused.value.code == "bad-value"


# microphones


def test_blocks_of_a_pipe_come_in_order_the_silent_ones_too(place: str) -> None:
    os.mkfifo(f"{place}/sound")
    with (
        serve(Microphone(f"{place}/sound", rate=1000, block=0.01), "mic", is_on_zenoh=False) as it,
        connect_unix(it.socket, BOUND_S) as client,
    ):
        client.listen("data?queue=1000&mode=all&initial=0")
        samples = [each % 3 and -each for each in range(1000)] + [0] * 30
        data = struct.pack("<1030h", *samples)
        with open(f"{place}/sound", "wb", buffering=0) as pipe:
            for begin in range(0, len(data), 37):
                pipe.write(data[begin : begin + 37])
            blocks: list[bytes] = []
            while len(blocks) < 103:
                event = client.event(BOUND_S)
                assert event is not None
                assert not event.dropped
                raw = event.payload
                if raw:  # nothing is what is heard before anybody has opened the pipe
                    blocks.append(raw if isinstance(raw, bytes) else raw.encode())
            level = client.ask("level").value()
        assert b"".join(blocks) == data
        assert level == "0.0"
        assert client.ask("rate").value() == "1000.0"


def test_a_wav_file_is_played_as_fast_as_it_was_recorded(client: rtkit.Client, place: str) -> None:
    with wave.open(f"{place}/sound.wav", "wb") as sound:
        sound.setparams((2, 2, 8000, 0, "NONE", ""))
        sound.writeframes(struct.pack("<h", 16384) * 2 * 2000)  # a quarter of a second
    with serve(Microphone(f"{place}/sound.wav", block=0.05), "mic", is_on_zenoh=False):
        until(lambda: client.get("mic.status") == "ready", "it plays")
        assert (client.get("mic.rate"), client.get("mic.channels")) == (8000.0, 2)
        assert client.get("mic.level") == pytest.approx(0.5)
        assert len(client.get_bytes("mic.data")) == 0.05 * 8000 * 4
        until(lambda: client.get("mic.status") == "ended", "it ends")


def test_what_is_no_sound_is_told(client: rtkit.Client, place: str) -> None:
    Path(f"{place}/sound.wav").write_bytes(b"no sound")
    with serve(Microphone(f"{place}/sound.wav"), "mic", is_on_zenoh=False):
        until(lambda: "failed" in client.get("mic.status"), "it is told")
