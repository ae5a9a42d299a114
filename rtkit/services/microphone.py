"""Microphone, a sensor: blocks of sound (PCM, 16 bit, little-endian), one event each, in order.

``arecord -t raw -f S16_LE -r 16000 > sound`` fills a pipe that it reads; a WAV file is played as
fast as it was recorded.
"""

from __future__ import annotations

import math
import sys
import wave
from array import array
from time import monotonic
from typing import Annotated, Final, Self

import rtkit
from rtkit import init_of
from rtkit.services.frames import ORIGIN, Frames
from rtkit.services.sensor import MIDDLE, DeviceSensor, Pose6, within


class Microphone(DeviceSensor):
    """Microphone. A listener with ``?queue=100&mode=all`` gets each block, in order.

    Args:
        device: A pipe or device that sends samples, or a file ``NAME.wav``.
        rate: Samples in a second [Hz]; a WAV file tells its own.
        channels: Samples at a time; a WAV file tells its own.
        block: Length of a block [s].
        location, base, frames: See `Sensor`.
        silence: How long no sample may come before `status` calls it silent [s]; 0: for ever.
            A quiet device sends samples, too.

    Attributes:
        data: The latest block; empty while there is none.
        channels: Samples at a time.
        format: Of a sample.
    """

    type: Final[tuple[str, ...]] = ("microphone", "sensor")  # type: ignore[misc]
    range: Final[tuple[float, ...]] = (-32768, 32767)  # type: ignore[misc]
    format: Final[str] = "s16le"
    data: Final[bytes] = b""
    channels: Final[int] = 1

    def __init__(
        self,
        device: str,
        rate: int = 16000,
        channels: int = 1,
        block: Annotated[float, rtkit.Unit("s")] = 0.1,
        location: Pose6 = MIDDLE,
        base: str = "",
        frames: Frames | None = None,
        silence: Annotated[float, rtkit.Unit("s")] = 2.0,
    ) -> None:
        super().__init__(device, 0, location, base, frames, silence)
        within("rate", rate, 1, 1e6)
        within("channels", channels, 1, 64)
        self.block: Final[Annotated[float, rtkit.Unit("s")]] = within("block", block, 0.005, 5)
        self._set_format(rate, channels)
        self._rest_of_block = b""

    def __enter__(self) -> Self:
        if not self.device.lower().endswith(".wav"):
            return super().__enter__()
        self._work(self._play)
        return self

    def get_level(self) -> float:
        """Loudness of the latest block: 0 to 1, the root of its mean square."""
        samples = array("h", self.data)
        if sys.byteorder == "big":
            samples.byteswap()
        squares = sum(each * each for each in samples)
        return math.sqrt(squares / max(1, len(samples))) / 32768

    def _set_format(self, rate: int, channels: int) -> None:
        self._publish("rate", float(rate))
        self._publish("channels", channels)
        self._size = max(1, round(rate * self.block)) * channels * 2

    def _opened(self, descriptor: int) -> None:
        self._rest_of_block = b""

    def _take(self, data: bytes) -> None:
        data = self._rest_of_block + data
        while len(data) >= self._size:
            self._publish("data", data[: self._size])
            data = data[self._size :]
        self._rest_of_block = data

    def _rest(self) -> None:
        self._publish("data", b"")

    def _found(self) -> list[rtkit.Marker]:
        """See `Sensor`: the microphone itself, with how loud it is there."""
        return [rtkit.Marker(ORIGIN, type="microphone", level=self.get_level())]

    def _play(self) -> None:
        """Publish the blocks of a WAV file, each when it was heard."""
        try:
            with wave.open(self.device, "rb") as sound:
                if sound.getsampwidth() != 2:
                    raise wave.Error(f"{8 * sound.getsampwidth()} bit, not 16")
                self._set_format(sound.getframerate(), sound.getnchannels())
                self._changed("ready")
                count = self._size // (2 * sound.getnchannels())
                due = monotonic()
                while data := sound.readframes(count):
                    self._publish("data", data)
                    due += self.block
                    if self._ended.wait(max(0.0, due - monotonic())):
                        return
            self._changed("ended")
        except (OSError, EOFError, wave.Error) as error:
            self._changed(f"failed: {self.device}: {getattr(error, 'strerror', None) or error}")


MicrophoneInit = init_of(Microphone)
