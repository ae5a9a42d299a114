"""Measures methods of vision that are not active: they cost nothing beside the active one."""

from __future__ import annotations

import time
from collections.abc import Callable

from bench.harness import Lines, Row, paired

_PICTURES = 20


def _inactive() -> Lines:
    import cv2
    import numpy as np

    from rtkit.services import vision_methods
    from rtkit.services.images import decode, encode
    from rtkit.services.vision import Vision

    grain = np.random.default_rng(1).normal(200, 10, (480, 640, 3)).clip(0, 255).astype(np.uint8)
    shown = [cv2.circle(grain.copy(), (100 + 20 * each, 200), 40, (30, 30, 220), -1)
             for each in range(_PICTURES)]  # fmt: skip
    data = [encode(np.asarray(each, np.uint8), "jpeg") for each in shown]
    vision = Vision(active=("blobs",))
    colors = tuple(vision_methods.HUES)

    def ours(picture: bytes) -> None:
        vision.set_image(picture)
        assert len(vision.get_markers()) == 1

    def bare(picture: bytes) -> None:
        assert len(vision_methods.blobs(decode(picture), colors, 50.0)) == 1

    def each_ms(work: Callable[[bytes], None]) -> float:
        begin = time.perf_counter()
        for picture in data:
            work(picture)
        return (time.perf_counter() - begin) / _PICTURES * 1e3

    measured = paired(lambda: each_ms(ours), lambda: each_ms(bare))
    floor_is = "the method called by itself on the decoded picture"
    what = "vision: blobs of a picture of 640 x 480, two further methods inactive"
    yield Row(what, "ms", *measured, 1.1, True, floor_is)


PARTS = {"inactive": _inactive}
