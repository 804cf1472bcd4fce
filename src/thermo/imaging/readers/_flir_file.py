"""What FLIR's cameras write into a JPEG: the signal of each pixel, and the camera's settings."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
from jaxtyping import UInt16

_MARK: Final = b"FLIR\x00"
_APP1, _PICTURE, _END = 0xE1, 0xDA, 0xD9
_SIGNAL, _CAMERA = 1, 32
_HEAD: Final = 32
"""Bytes before the pixels of a signal [1]."""
_PNG: Final = b"\x89PNG"


class FlirSettings(NamedTuple):
    """What a camera was told and how it was calibrated, as the file holds it.

    Arguments:

    - `emissivity`, `distance` [m], `reflected_temperature`, `air_temperature`,
      `window_temperature` [K], `window_transmission`, `humidity` [1].
    - `planck_r1`, `planck_r2`, `planck_b`, `planck_f`, `planck_o`: of `PlanckConstants`.
    - `alpha_1`, `alpha_2`, `beta_1`, `beta_2`, `mixture`: of the air's transmission.
    - `warmest`, `coldest`: beyond which the maker's programs show no temperature [K].
    """

    emissivity: float
    distance: float
    reflected_temperature: float
    air_temperature: float
    window_temperature: float
    window_transmission: float
    humidity: float
    planck_r1: float
    planck_b: float
    planck_f: float
    alpha_1: float
    alpha_2: float
    beta_1: float
    beta_2: float
    mixture: float
    warmest: float
    coldest: float
    planck_o: float
    planck_r2: float


class FlirPicture(NamedTuple):
    """A radiometric picture.

    Arguments: `signal` of each pixel (rows, columns) [1]; `settings` of the camera.
    """

    signal: UInt16[np.ndarray, "rows columns"]
    settings: FlirSettings


def flir_picture(content: bytes) -> FlirPicture | None:
    """What FLIR's segments of a JPEG hold; None where it has none.

    Records are in the byte order of the camera's processor, which their first number tells; a PNG
    holds its pixels in that order too, whatever PNG asks for.

    Raises `ValueError`, in words, for what is truncated or not of this format.

    Source: the tags and structures of FLIR's files as P. Harvey's ExifTool documents them
    (exiftool.org/TagNames/FLIR.html).
    """
    parts: dict[int, bytes] = {}
    last = -1
    for segment in _segments(content):
        if segment.startswith(_MARK):
            number, last = segment[6], segment[7]
            if number in parts:
                raise ValueError(f"part {number} of FLIR's data twice")
            parts[number] = segment[8:]
    if not parts:
        return None
    if sorted(parts) != list(range(last + 1)):
        raise ValueError(f"{len(parts)} of {last + 1} parts of FLIR's data")
    records = _records(b"".join(parts[number] for number in range(last + 1)))
    missing = [name for name, kind in (("signal", _SIGNAL), ("camera", _CAMERA))
               if kind not in records]  # fmt: skip
    if missing:
        raise ValueError(f"no record of the {missing[0]}")
    return FlirPicture(_signal(records[_SIGNAL]), _settings(records[_CAMERA]))


def _segments(content: bytes) -> Iterator[bytes]:
    """The APP1 segments of a JPEG, without marker and length."""
    place = 2
    while place + 4 <= len(content) and content[place] == 0xFF:
        marker = content[place + 1]
        if marker == 0xFF:  # fills
            place += 1
            continue
        if marker in (_PICTURE, _END):
            return
        length = int.from_bytes(content[place + 2 : place + 4], "big")
        segment = content[place + 4 : place + 2 + length]
        if length < 2 or len(segment) != length - 2:
            raise ValueError("a segment that ends too early")
        if marker == _APP1:
            yield segment
        place += 2 + length


def _records(data: bytes) -> dict[int, bytes]:
    """Records by their kind."""
    if data[:4] not in (b"FFF\x00", b"AFF\x00") or len(data) < 64:
        raise ValueError("another beginning of FLIR's data")
    order = ">" if 100 <= struct.unpack_from(">I", data, 20)[0] < 200 else "<"
    place, count = struct.unpack_from(f"{order}2I", data, 24)
    found: dict[int, bytes] = {}
    for one in range(place, place + 32 * count, 32):
        if one + 32 > len(data):
            raise ValueError("a directory of records that ends too early")
        kind = struct.unpack_from(f"{order}H", data, one)[0]
        start, length = struct.unpack_from(f"{order}2I", data, one + 12)
        if kind not in (_SIGNAL, _CAMERA) or kind in found:
            continue
        found[kind] = data[start : start + length]
        if len(found[kind]) != length:
            raise ValueError("a record that ends too early")
    return found


def _order(record: bytes) -> str:
    """The byte order of a record, whose first number is 2."""
    return ">" if record[:2] == b"\x00\x02" else "<"


def _signal(record: bytes) -> UInt16[np.ndarray, "rows columns"]:
    from PIL import Image

    order = _order(record)
    columns, rows = struct.unpack_from(f"{order}2H", record, 2)
    pixels = record[_HEAD:]
    if pixels.startswith(_PNG):
        with Image.open(io.BytesIO(pixels)) as picture:
            signal = np.asarray(picture).astype(np.uint16)
        signal = signal.byteswap() if order == "<" else signal
    else:
        if len(pixels) < 2 * rows * columns:
            raise ValueError(f"{len(pixels)} bytes of {rows} x {columns} pixels")
        signal = np.frombuffer(pixels, f"{order}u2", rows * columns).reshape(rows, columns)
    if signal.shape != (rows, columns) or signal.size == 0:
        raise ValueError(f"a signal of shape {signal.shape} in place of {(rows, columns)}")
    return signal.astype(np.uint16)


def _settings(record: bytes) -> FlirSettings:
    if len(record) < 784:
        raise ValueError(f"{len(record)} bytes about the camera")
    order = _order(record)

    def numbers(place: int, kinds: str) -> tuple[float, ...]:
        return struct.unpack_from(order + kinds, record, place)

    told = [*numbers(32, "6f"), *numbers(60, "f")]
    if told[-1] > 2:  # some cameras write per cent
        told[-1] /= 100
    told += [*numbers(88, "3f"), *numbers(112, "5f"), *numbers(152, "2f"), *numbers(776, "if")]
    return FlirSettings._make(told)
