"""Data types of the module ``Img``: camera images as the vision components exchange them.

`rtkit.component.sensors.CameraImage` is another type of the same name, of the module ``RTC``.
"""

# Names of fields are those of the interface definitions; values used as defaults never change.

from __future__ import annotations

from enum import Enum

from rtkit.component.typenames import register_all
from rtkit.component.types import EPOCH, Double, Long, Short, Time
from rtkit.fast_dataclass import dataclass

Elements = tuple[Double, Double, Double, Double, Double]
Row = tuple[Double, Double, Double, Double]
Mat44 = tuple[Row, Row, Row, Row]

_NO_ELEMENTS: Elements = (0.0, 0.0, 0.0, 0.0, 0.0)
_IDENTITY: Mat44 = (
    (1.0, 0.0, 0.0, 0.0),
    (0.0, 1.0, 0.0, 0.0),
    (0.0, 0.0, 1.0, 0.0),
    (0.0, 0.0, 0.0, 1.0),
)


class ColorFormat(Enum):
    """Layout of the pixels of an image; names without CF are FourCC codes."""

    CF_UNKNOWN = 0
    CF_RGB = 1
    CF_GRAY = 2
    CF_JPEG = 3
    CF_PNG = 4
    RGB = 5
    RLE8 = 6
    RLE = 7
    RAW = 8
    RGBA = 9
    RGBT = 10
    AYUV = 11
    CLJR = 12
    CYUV = 13
    GREY = 14
    IRAW = 15
    IUYV = 16
    IY41 = 17
    IYU1 = 18
    IYU2 = 19
    HDYC = 20
    UYNV = 21
    UYVP = 22
    V210 = 23
    V422 = 24
    V655 = 25
    VYUV = 26
    YUNV = 27
    YVYU = 28
    Y41P = 29
    Y211 = 30
    Y41T = 31
    Y42T = 32
    YUVP = 33
    Y800 = 34
    Y8 = 35
    Y16 = 36


@dataclass(frozen=True, slots=True)
class ImageData:
    """Width and height [pixel], format and pixel data of a still image."""

    width: Long = 0
    height: Long = 0
    format: ColorFormat = ColorFormat.CF_UNKNOWN
    raw_data: bytes = b""


@dataclass(frozen=True, slots=True)
class CameraIntrinsicParameter:
    """Five elements of the camera matrix, and its distortion."""

    matrix_element: Elements = _NO_ELEMENTS
    distortion_coefficient: tuple[Double, ...] = ()


@dataclass(frozen=True, slots=True)
class CameraImage:
    """An image with the parameters of the camera that took it."""

    captured_time: Time = EPOCH
    image: ImageData = ImageData()
    intrinsic: CameraIntrinsicParameter = CameraIntrinsicParameter()
    extrinsic: Mat44 = _IDENTITY


@dataclass(frozen=True, slots=True)
class TimedCameraImage:
    """An image of a camera, and when; error code 0 means none."""

    tm: Time = EPOCH
    data: CameraImage = CameraImage()
    error_code: Long = 0


@dataclass(frozen=True, slots=True)
class MultiCameraImage:
    """Images of several cameras."""

    image_seq: tuple[CameraImage, ...] = ()
    camera_set_id: Long = 0


@dataclass(frozen=True, slots=True)
class TimedMultiCameraImage:
    """Images of several cameras, and when; error code 0 means none."""

    tm: Time = EPOCH
    data: MultiCameraImage = MultiCameraImage()
    error_code: Long = 0


@dataclass(frozen=True, slots=True)
class NamedValue:
    """A name and a value."""

    name: str = ""
    value: str = ""


@dataclass(frozen=True, slots=True)
class CameraDeviceProfile:
    """Identity and intrinsic parameters of a camera."""

    devtypeid: str = ""
    guid: str = ""
    unit: Short = 0
    vendor_name: str = ""
    model_name: str = ""
    intrinsic: CameraIntrinsicParameter = CameraIntrinsicParameter()
    properties: tuple[NamedValue, ...] = ()


register_all(globals(), "Img")
