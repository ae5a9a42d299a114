"""Camera, a sensor: pictures of a video device, of recordings, or of a simulated world.

``rtserve rtkit.services.camera:Camera cam -a /dev/video0 --http 8080``; a browser shows
``<img src="/ps/cam/image?stream">``. Needs the extra ``vision``.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator
from contextlib import closing
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

import rtkit
from rtkit import init_of
from rtkit.services.device import LOOK_S, SilenceLimit
from rtkit.services.frames import ORIGIN, Frames
from rtkit.services.images import decode, encode, opencv
from rtkit.services.sensor import MIDDLE, Pose6, Sensor, within

if TYPE_CHECKING:
    from rtkit.services.images import Picture

_STILL = (".jpg", ".jpeg", ".png")


class Camera(Sensor):
    """Camera that looks along its x; `image` is listened to at its rate, and encoded only then.

    Args:
        source: A video device (``/dev/video0``), a video, a picture, or a folder of pictures,
            which are shown one after the other, over and over.
        rate: Pictures in a second [Hz].
        field: Angle from the left to the right of the picture [rad].
        location, base, frames: See `Sensor`.
        look: Returns a picture, an array of rows of red, green and blue, in place of a source.
        silence: How long no picture may come from a source that is open before `status` calls it
            silent [s]; 0: for ever.
    """

    type: Final[tuple[str, ...]] = ("camera", "sensor")  # type: ignore[misc]

    def __init__(
        self,
        source: str = "",
        rate: Annotated[float, rtkit.Unit("Hz")] = 10.0,
        field: Annotated[float, rtkit.Unit("rad")] = 1.2,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
        look: Callable[[], Any] | None = None,
        silence: Annotated[float, rtkit.Unit("s")] = 3.0,
    ) -> None:
        super().__init__(location, base, frames)
        self.rate: Final[Annotated[float, rtkit.Unit("Hz")]] = within("rate", rate, 1e-3)  # type: ignore[misc]
        self.source: Final[str] = str(source)
        self.field: Final[Annotated[float, rtkit.Unit("rad")]] = within("field", field, 0.01, 3)
        self._look = look
        self._silence_s = within("silence", silence, 0)
        self._lock = threading.Lock()
        self._picture: Picture | None = None
        self._encoded: dict[tuple[str, int], bytes] = {}
        self._looked_at = -1e9
        if look is None:
            self._publish("status", f"waiting: {self.source}: not opened")

    def __enter__(self) -> Self:
        if self._look is None:
            opencv()
            self._work(self._run)
        return self

    def get_image(self, format: str = "jpeg", width: int = 0) -> bytes:
        """The latest picture, as jpeg or png; 0 leaves its width as it is."""
        with self._lock:
            if self._look is not None and monotonic() - self._looked_at >= 1 / self.rate:
                self._looked_at = monotonic()
                self._show(self._look()[:, :, ::-1])
            if self._picture is None:
                raise rtkit.PropertyError("no-service", f"no picture: {self.status}")
            known = self._encoded.get((format, width))
            if known is None:
                known = encode(self._picture, format, width)
                if len(self._encoded) < 8:
                    self._encoded[format, width] = known
            return known

    def get_data(self) -> bytes:
        """The latest picture, as it is when nothing else is asked for."""
        return self.get_image()

    def _found(self) -> list[rtkit.Marker]:
        """See `Sensor`: the camera itself."""
        return [rtkit.Marker(ORIGIN, type="camera", field=self.field)]

    def _show(self, picture: Picture) -> None:
        self._picture, self._encoded = picture, {}

    def _run(self) -> None:
        while not self._ended.is_set():
            try:
                with closing(_Reader(self.source)) as reader:
                    while not self._ended.is_set():
                        self._show_next(reader)
                        self._ended.wait(1 / self.rate)
                return
            except OSError as error:
                why = error.strerror or str(error)
                self._forget()
            except rtkit.PropertyError as error:
                why = str(error)
            self._report(f"waiting: {self.source}: {why}")
            self._ended.wait(LOOK_S)

    def _show_next(self, reader: _Reader) -> None:
        """Show the next picture, however long it takes to come; none when the service ends."""
        silence = SilenceLimit(self._silence_s)
        reader.ask()
        while not self._ended.is_set():
            try:
                picture = reader.answer(LOOK_S)
            except Empty:
                if (state := silence.state()) != "ready":
                    self._forget()
                    self._report(state)
                continue
            with self._lock:
                self._show(picture)
            self._report("ready")
            return

    def _forget(self) -> None:
        """Have no picture: nobody sees by what is not there any more."""
        with self._lock:
            self._picture, self._encoded = None, {}

    def _report(self, status: str) -> None:
        if self.status != status:
            self._publish("status", status)


class _Reader:
    """Reads pictures of a source one by one, on a thread that a silent one may hold for ever."""

    def __init__(self, source: str) -> None:
        self._asks: SimpleQueue[bool] = SimpleQueue()
        self._answers: SimpleQueue[Picture | Exception] = SimpleQueue()
        threading.Thread(target=self._run, args=(source,), daemon=True).start()

    def ask(self) -> None:
        """Have the next picture read."""
        self._asks.put(True)

    def answer(self, timeout_s: float) -> Picture:
        """Return what was asked for; queue.Empty: it is not there yet.

        Raises:
            OSError: The source cannot be opened, or read.
            PropertyError: It holds no picture, or no more of them.
        """
        answer = self._answers.get(timeout=timeout_s)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def close(self) -> None:
        """Read no more, as soon as what is being read has come."""
        self._asks.put(False)

    def _run(self, source: str) -> None:
        with closing(_pictures(source)) as pictures:
            while self._asks.get():
                try:
                    self._answers.put(next(pictures))
                except StopIteration:
                    self._answers.put(rtkit.PropertyError("no-service", "no more pictures"))
                except Exception as error:  # whoever asked is told
                    self._answers.put(error)


def _pictures(source: str) -> Generator[Picture]:
    """Yield the pictures of a source; OSError, PropertyError: it cannot be opened, or read."""
    os.stat(source)
    is_folder = os.path.isdir(source)
    names = (
        [os.path.join(source, each) for each in sorted(os.listdir(source))]
        if is_folder
        else [source]
    )
    stills = [each for each in names if each.lower().endswith(_STILL)]
    for name in stills:
        with open(name, "rb") as file:
            yield decode(file.read())
    if stills or is_folder:
        return
    capture = opencv().VideoCapture(source)
    try:
        while (read := capture.read())[0]:
            yield read[1]
    finally:
        capture.release()


CameraInit = init_of(Camera)
