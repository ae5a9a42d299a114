"""Measures methods of vision that are not active: they cost nothing beside the active one."""

from __future__ import annotations

import time
from collections.abc import Callable

from bench.harness import Lines, Row
from bench.pairs import paired

_PICTURES = 20
_FORMS = {"edges": "segments", "blobs": "markers", "fiducials": "markers"}


def _pictures() -> list[bytes]:
    import cv2
    import numpy as np

    from rtkit.services.images import encode

    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    grain = np.random.default_rng(1).normal(200, 10, (480, 640, 3)).clip(0, 255).astype(np.uint8)
    grain[300:400, 50:150] = cv2.aruco.generateImageMarker(words, 1, 100)[:, :, None]
    shown = [cv2.circle(grain.copy(), (100 + 20 * each, 200), 40, (30, 30, 220), -1)
             for each in range(_PICTURES)]  # fmt: skip
    return [encode(np.asarray(each, np.uint8), "jpeg") for each in shown]


def _inactive() -> Lines:
    from rtkit.services.images import decode
    from rtkit.services.vision import METHODS, Method, Vision
    from rtkit.services.vision_methods import Lens

    data = _pictures()

    def each_ms(work: Callable[[bytes], None]) -> float:
        begin = time.perf_counter()
        for picture in data:
            work(picture)
        return (time.perf_counter() - begin) / _PICTURES * 1e3

    for name, form in _FORMS.items():
        vision, alone = Vision(active=(name,)), Vision().methods[name]

        def ours(
            picture: bytes, vision: Vision = vision, name: str = name, form: str = form
        ) -> None:
            vision.set_image(picture)
            assert vision.methods[name].get_result(form)  # type: ignore[arg-type]

        def bare(picture: bytes, alone: Method = alone) -> None:
            pixels = decode(picture)
            alone._compute(pixels, Lens.of(pixels, 1.2))  # noqa: SLF001

        measured = paired(lambda: each_ms(ours), lambda: each_ms(bare))
        assert not any(vision.methods[each].runs for each in METHODS if each != name)
        floor_is = "the method called by itself on the decoded picture"
        what = f"vision: {name} of a picture of 640 x 480, two further methods inactive"
        yield Row(what, "ms", measured, 1.1, True, floor_is)


PARTS = {"inactive": _inactive}
