"""The paper's control-point network."""

from __future__ import annotations

from typing import final

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, PyTree

from thermo.fields._extension import Extension, interpolating_extension
from thermo.fields._field import AbstractExtendedField
from thermo.fields._head import AbstractHead
from thermo.fields._quantity import Quantity
from thermo.fields._surface_graph import ControlPoints
from thermo.mesh import Mesh


def encode(points: Float[Array, "controls 3"], octaves: int) -> Float[Array, "controls features"]:
    """Positional encoding [p, |p|, sin(2^l pi p), cos(2^l pi p)] of normalised positions [1].

    Arguments:

    - `points`: in [-1, 1]^3, (controls, 3) [1]; `octaves`: l = 0 ... octaves - 1.

    Source: paper, appendix B.5 (checklist C2).
    """
    parts = [points, jnp.linalg.norm(points, axis=1, keepdims=True)]
    for octave in range(octaves):
        angle = 2.0**octave * jnp.pi * points
        parts += [jnp.sin(angle), jnp.cos(angle)]
    return jnp.concatenate(parts, axis=1)


@final
class NetworkField(AbstractExtendedField):
    """phi_i = head(g(encode(p_i))) with a small network g.

    - `points`: control points normalised to the bounding box, (controls, 3) [1].
    - `network`: g; `shift`: u of the initial value [1].

    Source: paper, appendix B.5 (checklist C1 to C3).
    """

    quantity: Quantity = eqx.field(static=True)
    extension: Extension
    head: AbstractHead
    points: Float[np.ndarray | Array, "controls 3"]
    shift: Float[Array, ""]
    network: eqx.nn.MLP
    octaves: int = eqx.field(static=True)

    def parameters(self) -> PyTree[Float[Array, "..."]]:
        """Weights and biases [1]."""
        return eqx.filter(self.network, eqx.is_inexact_array)

    def with_parameters(self, parameters: PyTree[Float[Array, "..."]]) -> NetworkField:
        """The same field with other weights [1]."""
        network = eqx.combine(parameters, self.network)
        return eqx.tree_at(lambda field: field.network, self, network)

    def control_values(self) -> Float[Array, " controls"]:
        """Physical values at the controls, in the quantity's unit."""
        features = encode(jnp.asarray(self.points), self.octaves)
        return self.head.value(self.shift + jax.vmap(self.network)(features)[:, 0])


def network_field(
    quantity: Quantity,
    mesh: Mesh,
    head: AbstractHead,
    initial: float,
    controls: ControlPoints,
    *,
    seed: int = 0,
    octaves: int = 3,
    width: int = 32,
    depth: int = 2,
) -> NetworkField:
    """A network that starts close to `initial`, in the quantity's unit.

    Arguments:

    - `octaves`, `width`, `depth`: of the encoding and of the hidden layers [1].
    - `seed`: of the weights; the last layer starts small so that the field starts nearly uniform.
    """
    low, high = mesh.nodes.min(0), mesh.nodes.max(0)
    points = 2 * (controls.points - low) / (high - low) - 1
    features = 4 + 6 * octaves
    network = eqx.nn.MLP(features, 1, width, depth, activation=jnp.tanh, key=jax.random.key(seed))
    last = network.layers[-1]
    small = (0.1 * last.weight, jnp.zeros(1))
    network = eqx.tree_at(lambda net: (net.layers[-1].weight, net.layers[-1].bias), network, small)
    shift = head.raw(jnp.asarray(float(initial)))
    extension = interpolating_extension(mesh, controls)
    return NetworkField(quantity, extension, head, points, shift, network, octaves)
