"""What is left open of a fit on the block: against slopes, more runs, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree

from thermo.errors import InputError
from thermo.inverse import (
    Estimate,
    FieldPosterior,
    Meshing,
    Prior,
    Stepping,
    bands,
    posterior,
    save_estimate,
    sensitivity,
)
from thermo.inverse._posterior import _parts

pytestmark = pytest.mark.usefixtures("bricks")

COUNT = 12


@pytest.fixture(scope="module")
def exact(meshing: Meshing) -> Meshing:
    """The cells of the fit for slopes as well."""
    return replace(meshing, order=2, coarse_tangents=False, corrected=True)


@pytest.fixture(scope="module")
def left(block: Path, fitted: Estimate, exact: Meshing, stepping: Stepping) -> FieldPosterior:
    return posterior(block, fitted, count=COUNT, meshing=exact, stepping=stepping)


# Far above what linear cells, and so few, are wrong by: no run weighs less for its misfit.
ROUGH = 8.0


@pytest.fixture(scope="module")
def plain(meshing: Meshing) -> Meshing:
    """Linear cells, with which the loss takes a tenth of the time, and what they make wrong."""
    return replace(meshing, coarse_tangents=False)


@pytest.fixture(scope="module")
def linear(fitted: Estimate) -> Estimate:
    return replace(fitted, order=1)


@pytest.fixture(scope="module")
def held(block: Path, linear: Estimate, plain: Meshing, stepping: Stepping) -> FieldPosterior:
    """With next to no step between neighbours, and without what cells and steps make wrong."""
    return posterior(
        block, linear, count=COUNT, meshing=plain, stepping=stepping, prior=Prior(step=1e-5),
        model_error=ROUGH,
    )  # fmt: skip


def test_the_mean_is_where_the_truth_is_and_the_field_may_be_uniform(left: FieldPosterior) -> None:
    middle, after, before = left.mean("conductivity")
    assert abs(middle - np.log(0.8)) < 3 * after and after < 0.05 and before > 4
    assert min(one.steps["conductivity"] for one in left.mixture) < 0.01
    assert sum(one.weight for one in left.mixture) == pytest.approx(1.0)
    assert np.all(np.abs(np.log(0.8) - middle) < 4 * left.deviation("conductivity"))
    assert np.abs(left.shift).max() > 0


@pytest.fixture(scope="module")
def one_value(
    block: Path, linear: Estimate, plain: Meshing, stepping: Stepping
) -> dict[str, float]:
    """By run, what its readings say of the logarithm of the one value [1]."""
    at = sensitivity(
        block, unknown=("conductivity",), meshing=plain, stepping=stepping,
        initial={"conductivity": float(linear.fields["conductivity"].faces[0])},
    )  # fmt: skip
    return {
        run: float(np.sum(slopes**2)) / (at.noise[run] ** 2 + ROUGH**2)
        for run, slopes in at.slopes.items()
    }


@pytest.mark.parametrize("way", [np.ones(COUNT), np.sin(1.0 + np.arange(COUNT))])
def test_the_loss_that_was_linearised_has_its_slope_and_its_curvature(
    held: FieldPosterior, way: np.ndarray
) -> None:
    loss = held.loss
    assert loss is not None
    # Against an even change stand the readings alone, against waves next to the prior alone.
    way = 0.05 * way / np.abs(way).max()
    square, slope = loss.of(loss.first)
    errors = []
    for size in (1.0, 0.5, 0.25):
        there, _ = loss.of(loss.first + size * way)
        errors.append(there - square - 2 * size * slope @ way)
    # The Taylor remainder falls with the square of the step, and is what the curvature says.
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2) < 0.1)
    assert errors[-1] == pytest.approx(way @ loss.curvature @ way / 16, rel=0.05)
    # Where slopes see the most probable fields next to nothing is to be gained.
    assert slope @ np.linalg.solve(loss.curvature, slope) < 0.1


def test_fields_have_the_order_of_the_slopes(fitted: Estimate) -> None:
    """Once they had the order of the fit, and took each other's variances."""
    one = fitted.fields["conductivity"]
    odd = {"volumetric_heat_capacity": one, "convection": one, "conductivity": one}
    names = list(_parts(replace(fitted, fields=odd))[-1])
    # A number for each, and where it ends in the columns of a Jacobian.
    columns, _ = ravel_pytree(
        {name: jnp.asarray([float(place)]) for place, name in enumerate(names)}
    )
    assert columns.tolist() == [0.0, 1.0, 2.0]


def test_with_no_step_between_neighbours_it_is_what_one_value_leaves(
    held: FieldPosterior, one_value: dict[str, float]
) -> None:
    (only,) = held.mixture
    assert np.allclose(only.covariance, only.covariance[0, 0], rtol=1e-3)
    assert only.covariance[0, 0] == pytest.approx(1 / sum(one_value.values()), rel=0.02)
    assert np.all(held.shift == 0)


def test_fewer_runs_leave_more_open_and_a_folder_does_for_an_estimate(
    block: Path, linear: Estimate, held: FieldPosterior, plain: Meshing, stepping: Stepping,
    one_value: dict[str, float], tmp_path: Path,
) -> None:  # fmt: skip
    save_estimate(tmp_path / "estimate.npz", linear)
    one = posterior(
        block, tmp_path, count=COUNT, meshing=plain, stepping=stepping,
        prior=Prior(step=1e-5), runs=("cooling",), model_error=ROUGH,
    )  # fmt: skip
    assert one.shift.shape == (COUNT, 1) and held.shift.shape == (COUNT, 2)
    assert one.mixture[0].covariance[0, 0] == pytest.approx(1 / one_value["cooling"], rel=0.02)


def test_bands_hold_the_readings_of_a_run_that_was_not_fitted(
    block: Path, left: FieldPosterior
) -> None:
    # Cells this coarse are wrong by some hundredths of a kelvin under the lamp, by how many depends
    # on the mesh: on one of three a band with 0.05 K held 94.7 %.
    (found,) = bands(block, left, draws=8, model_error=0.08).values()
    assert found.deviation.shape == (len(found.time), len(found.points))
    # Before the lamp is on nothing depends on the field.
    assert found.deviation[0].max() < 1e-6 < found.deviation[-1].min()
    assert found.inside > 0.95
    again = bands(block, left, draws=8, runs=("test_lamp",), model_error=0.0)["test_lamp"]
    assert np.array_equal(again.deviation, found.deviation) and again.inside < found.inside


def test_one_draw_makes_no_band(block: Path, left: FieldPosterior) -> None:
    with pytest.raises(InputError) as caught:
        bands(block, left, draws=1)
    assert caught.value.where == "draws"


def test_an_estimate_of_another_object_is_refused(
    block: Path, fitted: Estimate, exact: Meshing
) -> None:
    other = replace(fitted.mesh, nodes=1.5 * fitted.mesh.nodes)
    with pytest.raises(InputError) as caught:
        posterior(block, replace(fitted, mesh=other), count=COUNT, meshing=exact)
    assert caught.value.where == "estimate" and "mm" in str(caught.value.value)
