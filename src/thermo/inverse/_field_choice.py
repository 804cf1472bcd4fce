"""How an unknown may vary over the object."""

from __future__ import annotations

from abc import abstractmethod
from typing import final

import equinox as eqx
import numpy as np

from thermo.fields import (
    AbstractField,
    AbstractHead,
    LinearHead,
    LogHead,
    Quantity,
    control_point_field,
    network_field,
    patchwise_field,
    place_control_points,
    two_material_field,
    uniform_field,
)
from thermo.mesh import Mesh

NO_PAIRS = np.zeros((0, 2), np.int32)


class AbstractFieldChoice(eqx.Module):
    """Makes the field of one quantity on a mesh."""

    @abstractmethod
    def make(
        self, quantity: Quantity, mesh: Mesh, initial: float, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """A field that starts at `initial`, in the quantity's unit, and its neighbouring pairs."""


class AbstractStagedChoice(AbstractFieldChoice):
    """A choice whose last stage fits another field than the first: a fit has two stages."""

    @abstractmethod
    def go_on(
        self, field: AbstractField, pairs: np.ndarray, mesh: Mesh, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """What the last stage fits, from the field and pairs [1] of the stage before."""


def _log_head(quantity: Quantity) -> AbstractHead:
    return LogHead(quantity.lower, quantity.upper)


@final
class Uniform(AbstractFieldChoice):
    """One value for the object."""

    def make(
        self, quantity: Quantity, mesh: Mesh, initial: float, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """A field that starts at `initial`, in the quantity's unit; no neighbours."""
        del seed
        return uniform_field(quantity, mesh, _log_head(quantity), initial), NO_PAIRS


@final
class Patchwise(AbstractFieldChoice):
    """One value a patch of the surface and what lies behind it; `patches` [1]."""

    patches: int = 12

    def make(
        self, quantity: Quantity, mesh: Mesh, initial: float, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """A field that starts at `initial`, in the quantity's unit, and its neighbouring pairs."""
        controls = place_control_points(mesh, self.patches, seed=seed)
        head = _log_head(quantity)
        return patchwise_field(quantity, mesh, head, initial, controls), controls.pairs


@final
class OnControlPoints(AbstractFieldChoice):
    """Values on `count` [1] control points, interpolated along the surface."""

    count: int = 60

    def make(
        self, quantity: Quantity, mesh: Mesh, initial: float, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """A field that starts at `initial`, in the quantity's unit, and its neighbouring pairs."""
        controls = place_control_points(mesh, self.count, seed=seed)
        head = _log_head(quantity)
        return control_point_field(quantity, mesh, head, initial, controls), controls.pairs


@final
class TwoMaterials(AbstractStagedChoice):
    """Two values with a boundary between them whose place is found.

    A first stage fits values on `count` [1] control points. They are then parted into two groups,
    and the last stage fits the value of each and shifts the boundary between them, which must be
    known roughly before it can be sharp.
    """

    count: int = 100

    def make(
        self, quantity: Quantity, mesh: Mesh, initial: float, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """A field that starts at `initial`, in the quantity's unit, and its neighbouring pairs."""
        return OnControlPoints(self.count).make(quantity, mesh, initial, seed)

    def go_on(
        self, field: AbstractField, pairs: np.ndarray, mesh: Mesh, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """Two materials and their pairs [1]; the same field where it is uniform."""
        controls = place_control_points(mesh, self.count, seed=seed)
        values = np.asarray(field.control_values())
        parted = two_material_field(
            field.quantity, mesh, _log_head(field.quantity), controls, values
        )
        return (field, pairs) if parted is None else parted


@final
class Network(AbstractFieldChoice):
    """The paper's network on `count` [1] control points.

    - `octaves`, `width`, `depth`: of the network [1].
    - `linear`: the paper's linear head; otherwise a logarithmic one.
    """

    count: int = 60
    octaves: int = 3
    width: int = 32
    depth: int = 2
    linear: bool = False

    def make(
        self, quantity: Quantity, mesh: Mesh, initial: float, seed: int
    ) -> tuple[AbstractField, np.ndarray]:
        """A field that starts near `initial`, in the quantity's unit, and its pairs."""
        controls = place_control_points(mesh, self.count, seed=seed)
        head = LinearHead(quantity.lower, quantity.upper) if self.linear else _log_head(quantity)
        field = network_field(
            quantity,
            mesh,
            head,
            initial,
            controls,
            seed=seed,
            octaves=self.octaves,
            width=self.width,
            depth=self.depth,
        )
        return field, controls.pairs
