"""Radiometric JPEG of FLIR, built byte by byte."""

from __future__ import annotations

import io
import struct
from typing import Any

import numpy as np
from PIL import Image

R1, R2, B, F, OFFSET = 16000.0, 0.0125, 1430.0, 1.0, -7000
AIR, WINDOW = 303.15, 285.0
ALPHA, BETA, MIXTURE = (0.0066, 0.0126), (-0.0023, -0.0067), 1.9


def signal(kelvin: np.ndarray | float) -> np.ndarray:
    """Planck's law as FLIR's cameras have it [1]."""
    return R1 / (R2 * (np.exp(B / np.asarray(kelvin)) - F)) - OFFSET


def camera_info(
    order: str,
    *,
    emissivity: float = 1.0,
    reflected: float = 293.15,
    planck_b: float = B,
    distance: float = 0.0,
    humidity: float = 0.5,
    window: float = 1.0,
    limits: tuple[float, float] = (0.0, 0.0),
) -> bytes:
    info = bytearray(900)
    struct.pack_into(f"{order}H", info, 0, 2)
    seen = (emissivity, distance, reflected, AIR, WINDOW, window)
    struct.pack_into(f"{order}6f", info, 32, *seen)
    struct.pack_into(f"{order}f", info, 60, humidity)
    struct.pack_into(f"{order}3f", info, 88, R1, planck_b, F)
    struct.pack_into(f"{order}5f", info, 112, *ALPHA, *BETA, MIXTURE)
    struct.pack_into(f"{order}2f", info, 152, *limits)
    struct.pack_into(f"{order}if", info, 776, OFFSET, R2)
    return bytes(info)


def pixels(raw: np.ndarray, order: str, png: bool) -> bytes:
    rows, columns = raw.shape
    head = struct.pack(f"{order}3H", 2, columns, rows).ljust(32, b"\0")
    if not png:
        return head + raw.astype(f"{order}u2").tobytes()
    # Cameras write their own order into a PNG, whose own is the greatest byte first.
    stored = raw.astype("<u2")
    stream = io.BytesIO()
    Image.fromarray(stored.byteswap() if order == "<" else stored).save(stream, "PNG")
    return head + stream.getvalue()


def radiometric(
    raw: np.ndarray,
    date: str | None = None,
    part: str | None = None,
    *,
    maker: str = "FLIR Systems",
    order: str = "<",
    png: bool = False,
    parts: tuple[int, ...] = (0,),
    of: int = 1,
    **told: Any,
) -> bytes:
    signals, info = pixels(raw, order, png), camera_info(order, **told)
    start = 64 + 32 * 8
    entries = b""
    for kind, offset, length in ((1, start, len(signals)), (32, start + len(signals), len(info))):
        entries += struct.pack(">HHIIII", kind, 2, 100, 1, offset, length).ljust(32, b"\0")
    head = b"FFF\0" + b"\0" * 16 + struct.pack(">3I", 100, 64, 8)
    data = head.ljust(64, b"\0") + entries.ljust(32 * 8, b"\0") + signals + info
    size, segments = -(-len(data) // of), b""
    for number in parts:
        app1 = b"FLIR\0\x01" + bytes((number, of - 1)) + data[number * size : (number + 1) * size]
        segments += b"\xff\xe1" + struct.pack(">H", len(app1) + 2) + app1
    exif = Image.Exif()
    exif[0x010F] = maker
    if date is not None:
        exif.get_ifd(0x8769)[0x9003] = date
    if part is not None:
        exif.get_ifd(0x8769)[0x9291] = part
    stream = io.BytesIO()
    Image.fromarray(np.zeros((64, 64, 3), np.uint8)).save(stream, "JPEG", exif=exif)
    jpeg = stream.getvalue()
    return jpeg[:2] + segments + jpeg[2:]
