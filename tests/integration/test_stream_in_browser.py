"""A camera is drawn live by a real browser: ``<img src="…?stream">`` and nothing else."""

from __future__ import annotations

import browser
import numpy as np
import pytest

import rtkit
from rtkit.link import secret
from rtkit.services.images import encode

pytestmark = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
COLORS = {"red": (0, 0, 255), "green": (0, 255, 0), "blue": (255, 0, 0)}
LOOK = """
    const image = document.createElement("img");
    image.src = "/ps/cam/image?stream";
    document.body.append(image);
    const pen = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
    window.seen = () => { if (image.naturalWidth) pen.drawImage(image, 0, 0);
                          return [...pen.getImageData(8, 8, 1, 1).data].slice(0, 3).join(); };
"""


class Cam:
    image: bytes = b""


def picture(color: str, format: str) -> bytes:
    return encode(np.full((48, 64, 3), COLORS[color], np.uint8), format)


def test_a_browser_shows_each_picture_as_it_comes(place: str) -> None:
    cam = Cam()
    cam.image = picture("red", "png")
    with rtkit.serve(cam, "cam", http=0, is_on_zenoh=False) as served:
        known = secret.read()
        with browser.opened(place, known.user, known.password) as page:
            page.go(f"http://localhost:{served.http}/ps/cam")
            page.wait_for("document.getElementById('state')?.textContent === 'live'")
            page.evaluate(LOOK)
            page.wait_for("seen() === '255,0,0'")
            for color, shown in (("green", "0,255,0"), ("blue", "0,0,255"), ("red", "255,0,0")):
                cam.image = picture(color, "png")
                page.wait_for(f"seen() === '{shown}'")
            assert page.troubles() == []
