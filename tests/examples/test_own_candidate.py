"""The candidates that the guide writes, put to work on a body."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from box_scene import write_block

from thermo.discover import Setting, library
from thermo.inverse import Conditions
from thermo.inverse._conditions import conditions, make_model
from thermo.inverse._properties import Stated, properties
from thermo.mesh import box_mesh, face_areas
from thermo.observe import read_scene
from thermo.physics import assemble, discretise, heat_rate

GUIDE = Path(__file__).parents[2] / "docs" / "own_candidate.md"
MESH = box_mesh((0.03, 0.02, 0.01), (4, 3, 2))
SETTING = Setting(MESH, 2700.0, 30.0, 290.0, 340.0)


@pytest.fixture(scope="module")
def guide() -> dict[str, Any]:
    """What the page's Python leaves, with a search that only takes down what it was asked."""
    asked: dict[str, Any] = {}

    def discover(data: str, **more: Any) -> SimpleNamespace:
        asked.update(more, data=data)
        return SimpleNamespace(verdict="no_gap", effects=lambda: [])

    def predict(data: str, folder: str, additions: object) -> dict[str, SimpleNamespace]:
        asked.update(predicted=(data, folder, additions))
        scores = {"spatial": SimpleNamespace(rmse=0.05)}
        return {"held_out": SimpleNamespace(scores=scores)}

    fakes: dict[str, Any] = {
        "thermo.discover.discover": discover,
        "thermo.discover.load_effects": lambda folder, data, candidates: (folder, data, candidates),
        "thermo.inverse.predict": predict,
        "thermo.report.discovery_record": lambda _: {},
        "thermo.report.write_discovery": lambda *left: asked.update(left=left),
    }
    names: dict[str, Any] = {"__name__": "guide"}
    with pytest.MonkeyPatch.context() as patch:
        for name, fake in fakes.items():
            patch.setattr(name, fake)
        for block in re.findall(r"```python\n(.*?)```", GUIDE.read_text("utf-8"), re.S):
            exec(compile(block, GUIDE.name, "exec", dont_inherit=True), names)
    return names | {"asked": asked}


@pytest.fixture
def under(tmp_path: Path) -> Conditions:
    return conditions(read_scene(write_block(tmp_path)).runs["cooling"], discretise(MESH))


def test_both_are_looked_for_beside_the_library(guide: dict[str, Any]) -> None:
    found = [one.card.name for one in guide["asked"]["candidates"](SETTING)]
    known = [one.card.name for one in library(SETTING)]
    assert found == [*known, "painted_top", "warming_camera"]
    assert (GUIDE.parents[1] / guide["asked"]["data"] / "scene.json").exists()
    # What was left in a folder is predicted from there, with the same candidates.
    data, folder, (left, scene, candidates) = guide["asked"]["predicted"]
    assert data == scene == guide["asked"]["data"] and folder == left == guide["asked"]["left"][0]
    assert candidates is guide["asked"]["candidates"]


def test_the_paint_radiates_from_the_top_alone(guide: dict[str, Any], under: Conditions) -> None:
    body = properties(Stated(0.8, 1.54e6, 0.0, 0.0), {}, len(MESH.cells), len(MESH.faces))

    @jax.jit
    def lost(strength: jax.Array) -> jax.Array:
        model = make_model(discretise(MESH), body, under)
        painted = guide["PaintedTop"](strength[None]).to_model(model, under)
        hot = under.start(len(MESH.nodes))
        return -heat_rate(assemble(painted), hot, 0.0).sum()

    assert float(lost(jnp.asarray(0.0))) == pytest.approx(0.0, abs=1e-12)
    top = face_areas(MESH)[MESH.normals[:, 2] > 0.7].sum()
    steep = 5.670374419e-8 * (float(under.initial) ** 4 - float(under.surroundings) ** 4)
    assert float(lost(jnp.asarray(0.5))) == pytest.approx(0.5 * top * steep, rel=1e-6)
    assert float(jax.grad(lost)(jnp.asarray(0.0))) == pytest.approx(top * steep, rel=1e-6)


def test_the_camera_reads_more_as_it_warms_up(guide: dict[str, Any], under: Conditions) -> None:
    time = jnp.asarray([-1.0, 0.0, 30.0, 3000.0])
    true = jnp.full((4, 2), 300.0)
    read = guide["WarmingCamera"](jnp.asarray([0.5])).to_readings(true, time, under)
    assert np.allclose(read[:, 0] - 300.0, [0.0, 0.0, 0.5 * (1 - np.exp(-1)), 0.5])
