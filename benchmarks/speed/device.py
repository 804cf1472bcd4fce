"""A step, its gradient and a product beside the bandwidth of the device that JAX runs on.

    python benchmarks/speed/device.py [PROBLEM [STEPS]]

By default a million nodes and 60 steps. With JAX for CUDA installed this is the graphics card,
otherwise the processor. A product is taken to read each padded entry, its column and what it
multiplies, and to write its result, once each. Prints one line of JSON; nothing is kept.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from ours import Ours
from problem import SIZE, START, make_problem

from thermo.physics import StepMatrix, assemble, step_matrix

ENTRIES = 2**25
"""Numbers in each array of the triad: far more than any cache holds."""


def seconds(function: Callable, *arguments: Any) -> float:
    """Least time of five calls after the first, which compiles."""
    jax.block_until_ready(function(*arguments))
    best = np.inf
    for _ in range(5):
        begun = time.perf_counter()
        jax.block_until_ready(function(*arguments))
        best = min(best, time.perf_counter() - begun)
    return best


def triad() -> float:
    """Bandwidth [GB/s] of a = b + a / 2 in double precision, ten times over."""
    numbers = jnp.ones(ENTRIES)
    again = jax.jit(lambda a, b: jax.lax.fori_loop(0, 10, lambda _, a: b + 0.5 * a, a))
    return 240e-9 * ENTRIES / seconds(again, numbers, numbers)


def product(matrix: StepMatrix) -> float:
    """Bandwidth [GB/s] of a product with the matrix of a step, in its precision."""
    entries = sum(np.prod(rows.shape) for rows in matrix.rows)
    width = matrix.diagonal.dtype.itemsize
    bytes_moved = entries * (width + 4) + 3 * width * len(matrix.diagonal)
    vector = jnp.ones_like(matrix.diagonal)
    return 1e-9 * float(bytes_moved) / seconds(eqx.filter_jit(StepMatrix.mv), matrix, vector)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problem", nargs="?", default="s1m-rock")
    parser.add_argument("steps", nargs="?", type=int, default=60)
    given = parser.parse_args()
    ours = Ours(make_problem(given.problem, given.steps), 2e-5, "segments")
    conductivity = jnp.asarray(ours.problem.conductivity)
    start = jnp.full(len(ours.space.mesh.nodes), START)
    matrix = eqx.filter_jit(lambda model: step_matrix(assemble(model), start, SIZE))(ours.model)
    single = jax.tree.map(lambda a: a.astype("float32") if eqx.is_inexact_array(a) else a, matrix)
    target = jnp.zeros((given.steps, len(ours.places)))
    scale = 1e3 / given.steps
    record = {
        "problem": given.problem,
        "steps": given.steps,
        "nodes": len(start),
        "device": jax.devices()[0].device_kind,
        "triad_gb_s": triad(),
        "product_gb_s": product(matrix),
        "product_single_gb_s": product(single),
        "forward_ms_per_step": scale * seconds(ours.forward(), conductivity),
        "gradient_ms_per_step": scale * seconds(ours.gradient(target), conductivity),
    }
    print(json.dumps(record))


if __name__ == "__main__":
    main()
