"""Photographs of a coloured ball, by the closed form of a ray that meets it."""

from __future__ import annotations

import numpy as np

from thermo.imaging import Camera, looking_at, rays
from thermo.reconstruct import Photograph

CENTRE, RADIUS = np.array([0.10, -0.05, 0.02]), 0.03  # m
PIXELS, PARTS = 32, 4


def cameras(count: int, turn: float = 0.0) -> list[Camera]:
    """Cameras all about the ball, 0.2 m away."""
    number = np.arange(count) + 0.5
    height = 1 - 2 * number / count
    angle = np.pi * (1 + 5**0.5) * number + turn
    flat = np.sqrt(1 - height**2)
    places = CENTRE + 0.2 * np.stack([flat * np.cos(angle), flat * np.sin(angle), height], axis=1)
    middle = ((PIXELS - 1) / 2,) * 2
    return [
        Camera(
            PIXELS, PIXELS, (2.2 * PIXELS,) * 2, middle,
            looking_at(place, CENTRE, np.array([0.0, 0.3, 1.0])), name=f"view{index}",
        )
        for index, place in enumerate(places)
    ]  # fmt: skip


def photograph(camera: Camera) -> Photograph:
    """Colour and mask as means of 4 x 4 rays a pixel."""
    part = (np.arange(PIXELS * PARTS) + 0.5) / PARTS - 0.5
    columns, rows = np.meshgrid(part, part)
    sight = rays(camera, np.stack([columns.ravel(), rows.ravel()], axis=1))
    off = camera.place() - CENTRE
    along = sight @ off
    under = along**2 - (off @ off - RADIUS**2)
    hit = under > 0
    normal = (off + (-along - np.sqrt(np.where(hit, under, 0.0)))[:, None] * sight) / RADIUS
    colour = np.where(hit[:, None], 0.5 + 0.35 * np.sin(4 * normal + [0.0, 1.0, 2.0]), 0.0)
    shape = (PIXELS, PARTS, PIXELS, PARTS)
    mask = hit.reshape(shape).mean(axis=(1, 3))
    total = colour.reshape(*shape, 3).sum(axis=(1, 3))
    mean = total / np.maximum(mask * PARTS**2, 1e-9)[..., None]
    return Photograph(camera, mean, mask, f"{camera.name}.png")
