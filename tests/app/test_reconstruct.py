"""`thermo reconstruct`: photographs of a ball become a surface in metres."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coloured_ball import CENTRE, RADIUS, cameras, photograph
from PIL import Image

from thermo.app._metric_scale import stated_scale
from thermo.app._reconstruct import _photographs
from thermo.errors import InputError
from thermo.imaging import View, pixel_centres, rays, read_cameras, write_transforms
from thermo.mesh import read_surface
from thermo.reconstruct import MetricScale, _extract_surface, _picture
from thermo.report import _figure_turntable
from thermo.report._figure_turntable import VIEWS as SIDES

from .conftest import Command

UNIT = 0.04  # m, of the file of cameras
EDGE = 32  # pixels, as the photographs have
SMALL = (
    "training.steps=150", "training.rays=192", "training.cells=[8,16]", "training.width=32",
    "training.rate=0.01", "training.search=16", "training.sections=16", "triangles=600",
)  # fmt: skip


@pytest.fixture(scope="session")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of photographs with alpha and their cameras, in a unit that the file does not say.

    Beside them depths along the cameras' axes in metres, and distances of cameras.
    """
    folder = tmp_path_factory.mktemp("pictures")
    views, lines = [], ["# camera camera metres"]
    (folder / "depths").mkdir()
    for number, camera in enumerate(cameras(12)):
        made = photograph(camera)
        assert made.mask is not None
        both = np.concatenate([made.colour, made.mask[..., None]], axis=2)
        Image.fromarray(np.round(255 * both).astype(np.uint8), "RGBA").save(folder / made.file)
        views.append(View(camera, made.file))
        sight = rays(camera, pixel_centres(camera))
        off = camera.place() - CENTRE
        along = sight @ off
        with np.errstate(invalid="ignore"):
            depth = -along - np.sqrt(along**2 - (off @ off - RADIUS**2))
        depth *= sight @ camera.pose[2, :3]
        np.save(folder / "depths" / f"view{number}.npy", depth.reshape(made.mask.shape))
    for first, second in ((0, 5), (1, 7), (2, 9), (3, 11), (4, 8)):
        apart = np.linalg.norm(views[first].camera.place() - views[second].camera.place())
        lines.append(f"view{first} view{second}.png {apart:.9f}")
    (folder / "distances.txt").write_text("\n".join(lines))
    write_transforms(folder / "transforms.json", views)
    table = json.loads((folder / "transforms.json").read_text())
    table.pop("metres_per_unit", None)
    for frame in table["frames"]:
        matrix = np.asarray(frame["transform_matrix"])
        matrix[:3, 3] /= UNIT
        frame["transform_matrix"] = matrix.tolist()
    (folder / "transforms.json").write_text(json.dumps(table))
    return folder


@pytest.fixture(scope="session")
def stood(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("rebuilt") / "ball"


@pytest.fixture
def rebuilt(command: Command, pictures: Path, stood: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A ball in metres, by depths, with one photograph left out; pictures and grid are small."""
    monkeypatch.setattr(_figure_turntable, "_EDGE", EDGE)
    monkeypatch.setattr(_picture, "_RAYS", EDGE**2)
    monkeypatch.setattr(_extract_surface, "_CHUNK", 1 << 14)
    if not stood.exists():
        outcome = command(
            "reconstruct", f"cameras={pictures / 'transforms.json'}", f"out={stood}",
            f"scale.depths={pictures / 'depths'}", "left_out=[view6.png]", *SMALL,
        )  # fmt: skip
        assert outcome.code == 0, outcome.err
        assert "silhouettes overlap" in outcome.out and "a diffusivity" in outcome.out
        assert "PSNR [dB]" in outcome.err
    return stood


def test_it_leaves_a_surface_in_metres_and_how_it_came_about(rebuilt: Path) -> None:
    assert {one.name for one in rebuilt.iterdir()} == {
        "surface.ply", "turntable.png", "result.json",
    }  # fmt: skip
    surface = read_surface(rebuilt / "surface.ply", unit="m")
    assert np.linalg.norm(surface.vertices.mean(axis=0) - CENTRE) < 0.05 * RADIUS
    assert surface.volume() == pytest.approx(4 / 3 * np.pi * RADIUS**3, rel=0.06)
    record = json.loads((rebuilt / "result.json").read_text())
    assert record["verb"] == "reconstruct"
    scale = record["scale"]
    assert scale["factor"] == pytest.approx(UNIT, rel=0.01)
    assert 0 < scale["relative_deviation"] < 0.01
    assert scale["relative_deviation_of_diffusivity"] == 2 * scale["relative_deviation"]
    assert len(record["photographs"]) == 11 and list(record["left_out"]) == ["view6.png"]
    assert min(one["silhouette_overlap"] for one in record["photographs"].values()) > 0.9
    assert record["left_out"]["view6.png"]["psnr"] > 15
    assert record["surface"]["volume"] == pytest.approx(surface.volume(), rel=1e-6)
    assert record["configuration"]["training"]["steps"] == 150
    with Image.open(rebuilt / "turntable.png") as shown:
        assert shown.size == (SIDES * EDGE, 2 * EDGE)


def test_register_takes_its_folder_and_how_well_its_scale_is_known(
    rebuilt: Path, command: Command, pictures: Path, tmp_path: Path
) -> None:
    views = [View(camera, f"{camera.name}.npz") for camera in cameras(2)]
    time = np.arange(4.0)
    for one in views:
        frames = np.full((4, 32, 32), 300.0, np.float32)
        np.savez(tmp_path / one.file, time=time, temperature=frames)
    write_transforms(tmp_path / "thermal.json", views)
    said = command(
        "register", f"cameras={tmp_path / 'thermal.json'}", f"surface={rebuilt}",
        f"out={tmp_path / 'scene'}", "ambient_temperature=300", "initial_temperature=300",
        "material.density=1000", "material.heat_capacity=1000", "surface_exchange.convection=10",
        "surface_exchange.emissivity=0.9", "samples.count=20", "recording.faults=false",
        "material.conductivity=1", "samples.margin=0",
    )  # fmt: skip
    assert said.code == 0, said.err
    scene = json.loads((tmp_path / "scene" / "scene.json").read_text())
    record = json.loads((rebuilt / "result.json").read_text())
    assert scene["scale_deviation"] == record["scale"]["relative_deviation"]
    refused = command(
        "register", f"cameras={tmp_path / 'thermal.json'}", f"surface={pictures}",
        f"out={tmp_path / 'other'}", "ambient_temperature=300",
    )  # fmt: skip
    assert refused.code == 2 and "thermo reconstruct" in refused.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("scale.depths=nowhere",), "too few"),
        (("scale.cameras=nowhere.txt",), "cannot be read"),
        (("scale.length={from:[0,0,0],to:[1,0,0],metres:0.1}",), "deviation"),
        (("scale.length={from:[0,0],to:[1,0,0],metres:0.1,deviation:0.01}",), "scale.length.from"),
        (("scale.depths=x", "camera_scale=2"), "two ways"),
        (("training.steps=0",), "training.steps"),
        (("training.cells=[64,16]",), "training.cells"),
        (("+training.speed=3",), "training.speed"),
        (("left_out=[nobody.png]",), "nobody.png"),
        (("threshold=2",), "threshold"),
        (("masks=somewhere", "threshold=auto"), "two ways"),
        (("bridged=3",), "bridged"),
        (("images=nowhere",), "nowhere"),
        (("box=[[0,0,0],[0,1,1]]",), "box"),
        (("camera_axes=opencv",), "camera_axes=opengl"),
    ],
)
def test_what_makes_no_sense_is_refused_before_training(
    words: tuple[str, ...], said: str, command: Command, pictures: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    cameras_file = f"cameras={pictures / 'transforms.json'}"
    outcome = command("reconstruct", cameras_file, f"out={out}", *SMALL, *words)
    assert outcome.code == 2 and said in outcome.err, outcome.err
    assert not out.exists() or not list(out.iterdir())


def test_lengths_and_distances_of_cameras_give_the_unit(pictures: Path, tmp_path: Path) -> None:
    views = read_cameras(pictures / "transforms.json")
    ends = [views[number].camera.place() for number in (0, 1)]
    apart = float(np.linalg.norm(ends[0] - ends[1])) * UNIT
    length = {"from": ends[0].tolist(), "to": ends[1].tolist(), "metres": apart, "deviation": 1e-3}
    for way, value, deviation in (
        ("length", length, 1e-3 / apart),
        ("cameras", str(pictures / "distances.txt"), 0.0),
    ):
        scale = stated_scale(asked(way, value), views)
        assert isinstance(scale, MetricScale)
        assert scale.factor == pytest.approx(UNIT, rel=1e-6)
        assert scale.deviation == pytest.approx(deviation, abs=1e-6)
    for line in ("view0 nobody 0.2", "view0 view0.png 0.2", "view0 view1"):
        (tmp_path / "wrong.txt").write_text(f"view0 view1 0.1\n{line}\n")
        with pytest.raises(InputError, match="line 2"):
            stated_scale(asked("cameras", str(tmp_path / "wrong.txt")), views)


def test_a_threshold_that_is_found_masks_what_alpha_does(pictures: Path) -> None:
    views = read_cameras(pictures / "transforms.json")
    plain = {"cameras": pictures / "transforms.json", "images": None, "masks": None, "left_out": []}
    by_alpha, _ = _photographs(plain | {"threshold": None, "bridged": 0}, views)
    found, _ = _photographs(plain | {"threshold": "auto", "bridged": 1}, views)
    for one, other in zip(found, by_alpha, strict=True):
        assert one.mask is not None and other.mask is not None
        shown, wanted = one.mask > 0.5, other.mask > 0.5
        assert (shown & wanted).sum() > 0.85 * (shown | wanted).sum()
        assert not np.array_equal(one.mask, other.mask), "alpha is partial at rims"


def asked(way: str, value: Any) -> dict[str, Any]:
    none = {"length": None, "cameras": None, "depths": None}
    return {"camera_scale": None, "scale": none | {way: value}}


def test_depths_of_another_size_are_refused(pictures: Path, tmp_path: Path) -> None:
    views = read_cameras(pictures / "transforms.json")
    for number in range(3):
        np.save(tmp_path / f"view{number}.npy", np.ones((8, 9)))
    with pytest.raises(InputError, match="another size"):
        stated_scale(asked("depths", str(tmp_path)), views)
