"""`thermo render` and `thermo register`: pictures of a run, and a scene from pictures."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from box_scene import SIZE
from PIL import Image

from thermo.imaging import (
    Camera,
    Optics,
    PlanckConstants,
    Similarity,
    View,
    looking_at,
    measured_signal,
    motion_about,
    similarity_about,
    write_transforms,
)
from thermo.mesh import read_surface
from thermo.observe import read_scene

from .conftest import Command

PLACES = {"front": (0.03, -0.05, 0.06), "back": (-0.04, 0.05, 0.05)}
MATERIAL = (
    "material.density=1100", "material.heat_capacity=1400", "surface_exchange.convection=25",
    "surface_exchange.emissivity=0.6", "ambient_temperature=295",
)  # fmt: skip


def views(files: dict[str, str] | None = None) -> list[View]:
    made = []
    for name, place in PLACES.items():
        pose = looking_at(np.array(place), SIZE / 2, np.array([0.0, 0.0, 1.0]))
        camera = Camera(96, 72, (200.0, 200.0), (47.5, 35.5), pose, name=name)
        made.append(View(camera, (files or {}).get(name, "")))
    return made


@pytest.fixture
def cameras(tmp_path: Path) -> Path:
    path = tmp_path / "transforms.json"
    write_transforms(path, views())
    return path


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the films stay for all tests that read them."""
    return tmp_path_factory.mktemp("rendered") / "films"


@pytest.fixture
def films(
    command: Command, block: Path, cameras: Path, rendered: Path, tmp_path: Path
) -> list[Path]:
    """Copies that a test may change."""
    if not rendered.exists():
        words = (f"data={block}", "run=lamp", f"cameras={cameras}", f"out={rendered}")
        outcome = command("render", *words, "formats=[npz,gif]")
        assert outcome.code == 0, outcome.err
        assert "front.npz" in outcome.out and "back.png" in outcome.out
    out = shutil.copytree(rendered, tmp_path / "films")
    return [out / f"lamp_{name}.npz" for name in PLACES]


def registered(command: Command, block: Path, cameras: Path, films: list[Path], *more: str) -> Any:
    own = [] if any(one.startswith("scene=") for one in more) else [
        f"surface={read_scene(block).surface_path}", "unit=mm",
    ]  # fmt: skip
    words = [
        f"frames=[{','.join(map(str, films))}]", f"cameras={cameras}", *MATERIAL, *own,
        "initial_temperature=295", "samples.count=80", *more,
    ]  # fmt: skip
    return command("register", *words)


def test_a_film_is_brought_back_to_the_surface(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    for film in films:
        assert film.with_suffix(".gif").read_bytes()[:4] == b"GIF8"
        assert film.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
        assert (film.parent / f"{film.stem}_steps.png").stat().st_size > 5000
    out = tmp_path / "scene"
    outcome = registered(command, block, cameras, films, f"out={out}", "run=lamp", LAMP)
    assert outcome.code == 0, outcome.err
    scene, truth = read_scene(out), read_scene(block).runs["lamp"]
    run = scene.runs["lamp"]
    assert scene.unknown == ("conductivity",) and scene.convection == 25.0
    assert run.heater is not None and truth.heater is not None
    assert run.heater.power == truth.heater.power and run.initial_temperature == 295.0
    np.testing.assert_allclose(run.recording.time, truth.recording.time, atol=1e-6)
    # The pictures hold what five samples nearest to a vertex say: within what the samples span.
    assert run.recording.valid.all()
    spread = truth.recording.temperature
    assert (run.recording.temperature <= spread.max(axis=1, keepdims=True) + 1e-3).all()
    assert run.recording.temperature.max() > 0.5 * (spread.max() - 295.0) + 295.0
    with np.load(out / "lamp+samples.npz") as how:
        assert how["seen"].shape == (2, len(run.recording.points))
        # A pixel of 200 px focal length at some 70 mm, inclined: a third to one millimetre.
        assert 2e-4 < np.nanmedian(how["footprint"]) < 1e-3
    record = json.loads((out / "lamp+registration.json").read_text("utf-8"))
    # Two cameras above the block see its top and its four sides, not what it stands on.
    bottom = SIZE[0] * SIZE[1] / (2 * (SIZE[0] * SIZE[1] + SIZE[0] * SIZE[2] + SIZE[1] * SIZE[2]))
    assert 0.4 < record["coverage"] < 1 - bottom and "% of the surface" in outcome.out
    assert set(record["cameras"]) == set(PLACES)
    assert len(record["told"]) == 2 and all("No frame is missing" in one for one in record["told"])


def test_a_second_run_is_added_to_the_scene(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    out = tmp_path / "more"
    stood = tmp_path / "stood"
    shutil.copytree(block, stood)
    for ending in ("samples.npz", "registration.json"):
        (stood / f"lamp+{ending}").write_bytes(b"how the lamp's run was read")
    words = (f"out={out}", f"scene={stood}", "run=again", "held_out=true")
    outcome = registered(command, block, cameras, films, *words)
    assert outcome.code == 0, outcome.err
    scene = read_scene(out)
    assert set(scene.runs) == {*read_scene(block).runs, "again"} and scene.runs["again"].held_out
    for ending in ("samples.npz", "registration.json"):
        assert (out / f"lamp+{ending}").read_bytes() == (stood / f"lamp+{ending}").read_bytes()
        assert (out / f"again+{ending}").stat().st_size > 100
    outcome = registered(command, block, cameras, films, f"out={out}", f"scene={out}", "run=again")
    assert outcome.code == 2 and "there is a run of this name" in outcome.err


def test_a_scene_with_other_runs_is_not_laid_over(
    command: Command, own: Path, cameras: Path, films: list[Path]
) -> None:
    before = sorted((one.name, one.read_bytes()) for one in own.iterdir())
    outcome = registered(command, own, cameras, films, f"out={own}", "run=lamp")
    assert outcome.code == 2 and "a scene with other runs" in outcome.err
    assert f"scene={own}" in outcome.err
    assert sorted((one.name, one.read_bytes()) for one in own.iterdir()) == before


def test_frames_of_another_scale_are_seen_at_the_start(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    out = tmp_path / "scene"
    outcome = registered(command, block, cameras, films, f"out={out}", "initial_temperature=291")
    assert outcome.code == 0 and "first readings are +4 K off" in outcome.out
    for film in films:
        with np.load(film) as held:
            wrong = {"time": held["time"], "frames": 1.1 * held["frames"]}
        np.savez(film, **wrong)
    out = tmp_path / "other"
    outcome = registered(command, block, cameras, films, f"out={out}")
    assert outcome.code == 2 and "do not begin at the stated temperature" in outcome.err
    assert "+29.5 K off" in outcome.err and not out.exists()


def test_radiometry_brings_apparent_temperatures_to_true_ones(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    def peak(out: Path, *more: str) -> float:
        outcome = registered(command, block, cameras, films, f"out={out}", *more)
        assert outcome.code == 0, outcome.err
        return float(read_scene(out).runs["recording"].recording.temperature.max())

    plain = peak(tmp_path / "a")
    grey = ("optics.emissivity=0.8", "optics.reflected_temperature=295")
    # To first order 1/0.8 of what lies above the room; the band's curve takes a little off.
    rise = (peak(tmp_path / "b", *grey) - 295.0) / (plain - 295.0)
    assert 1.2 < rise < 1.25


LAMP = "heater={centre:[0.013,0.006,0.02],direction:[0,0,-1],radius:0.007,power:1.2,until:18}"


def under_a_lamp(films: list[Path], late: float, folder: Path) -> list[Path]:
    """Films of what warms as a thick body does, from a cold room's view, stamped too late.

    As warm at the end as the last frames given, with 9 s before the lamp and noise.
    """
    made = []
    random = np.random.default_rng(0)
    time = np.arange(-18, 40) / 2
    for film in films:
        with np.load(film) as held:
            rise = held["frames"].max(axis=0) - 295.0
        frames = 295.0 + rise * np.sqrt(np.maximum(time, 0.0) / 20.0)[:, None, None]
        frames = np.where(np.isnan(frames), 285.0, frames)
        frames += 0.02 * random.standard_normal(frames.shape)
        made.append(folder / film.name)
        np.savez(made[-1], time=time + late, frames=frames)
    return made


def test_a_surface_out_of_place_is_brought_to_the_silhouettes(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    stated = read_scene(block)
    right = read_surface(stated.surface_path, unit=stated.unit)
    middle = right.vertices.mean(axis=0)
    motion = np.array([0.03, -0.02, 0.04, 4e-4, -3e-4, 2e-4, 0.01])
    off = similarity_about(middle, motion)
    moved = trimesh.Trimesh(off.apply(right.vertices), right.triangles, process=False)
    moved.export(tmp_path / "off.ply")
    rooms = under_a_lamp(films, 0.0, tmp_path)
    given = (f"surface={tmp_path / 'off.ply'}", "unit=m")
    out = tmp_path / "scene"
    outcome = registered(
        command, block, cameras, rooms, *given, f"out={out}", "align=pose_and_scale"
    )
    assert outcome.code == 0, outcome.err
    assert "aligned: turned by" in outcome.out and "(one standard deviation)" in outcome.out
    assert "OUT OF PLACE" not in outcome.out
    scene = read_scene(out)
    check_record(out, scene.scale_deviation, "silhouettes", off, middle)
    found = read_surface(scene.surface_path, unit=scene.unit)
    distance = np.linalg.norm(found.vertices - right.vertices, axis=1)
    before = np.linalg.norm(moved.vertices - right.vertices, axis=1)
    assert scene.unit == "m" and scene.surface_path == out / "surface.ply"
    # A hundredth of the object's size: pixels are a third of a millimetre, the object 24 mm.
    assert distance.max() < 2.4e-4 < before.max() / 3
    refused = registered(command, block, cameras, rooms, f"scene={block}", "align=pose")
    assert refused.code == 2 and "is not moved" in refused.err


def check_record(
    out: Path, scale: float, source: str, off: Similarity, middle: np.ndarray
) -> dict[str, Any]:
    """What a surface that was `off` is known to, which must be what it is off by at the end."""
    record = json.loads((out / "recording+registration.json").read_text("utf-8"))["alignment"]
    assert record["to"] == source and record["untold"] == []
    assert record["rotation_deviation_unit"] == "rad" and record["place_deviation_unit"] == "m"
    found = Similarity(record["rotation"], record["shift"], record["scale"])
    left = motion_about(middle, found.after(off))
    deviation = [*record["rotation_deviation"], *record["place_deviation"]]
    deviation.append(record["scale_deviation"])
    # A pixel is a third of a millimetre, the object 24 mm; points are as well known.
    assert (np.array(deviation) > 1e-6).all() and (np.array(deviation) < 0.02).all()
    assert (np.abs(left) < 6 * np.array(deviation)).all(), left / deviation
    assert scale == pytest.approx(record["scale_deviation"], rel=1e-6)
    return record


def test_a_surface_out_of_place_is_brought_to_points(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    stated = read_scene(block)
    right = read_surface(stated.surface_path, unit=stated.unit)
    middle = (right.vertices.min(axis=0) + right.vertices.max(axis=0)) / 2
    off = similarity_about(middle, np.array([0.05, -0.04, 0.06, 4e-4, -3e-4, 2e-4, 0.02]))
    moved = trimesh.Trimesh(off.apply(right.vertices), right.triangles, process=False)
    moved.export(tmp_path / "off.ply")
    whole = trimesh.Trimesh(right.vertices, right.triangles, process=False)
    random = np.random.default_rng(0)
    points = trimesh.sample.sample_surface(whole, 2000, seed=random)[0]
    points += 5e-5 * random.standard_normal(points.shape)
    cloud = tmp_path / "cloud.ply"
    trimesh.PointCloud(1000 * points).export(cloud)
    out = tmp_path / "scene"
    words = (f"surface={tmp_path / 'off.ply'}", "unit=m", f"points={cloud}", f"out={out}")
    given = (*words, "points_unit=mm", "align=pose_and_scale")
    outcome = registered(command, block, cameras, films, *given)
    assert outcome.code == 0, outcome.err
    assert "mm off the surface" in outcome.out and "the scale to" in outcome.out
    scene = read_scene(out)
    record = check_record(out, scene.scale_deviation, "points", off, middle)
    assert record["residual"] == pytest.approx(5e-5, rel=0.2) and record["residual_unit"] == "m"
    found = read_surface(scene.surface_path, unit=scene.unit)
    assert np.linalg.norm(found.vertices - right.vertices, axis=1).max() < 5e-5
    kept = registered(command, block, cameras, films, *given, "scale_deviation=0.03")
    assert kept.code == 0 and read_scene(out).scale_deviation == 0.03
    for more, said in (
        (("points_unit=m",), "another size"),
        (("points_unit=null",), "the unit of the points is not known"),
        (("points_unit=cameras",), "length of the cameras' unit"),
        (("points_unit=ft",), "m, cm, mm, inch"),
        (("align=null",), "nothing is brought to the points"),
        (("points=null",), "no points that could have a unit"),
        (("points=nowhere.ply",), "nowhere.ply"),
    ):
        refused = registered(
            command, block, cameras, films, *given, f"out={tmp_path / 'no'}", *more
        )
        assert refused.code == 2 and said in refused.err, refused.err
    ball = trimesh.creation.icosphere(subdivisions=3, radius=9.0)
    trimesh.PointCloud(ball.vertices + 1000 * middle).export(cloud)
    films[0].write_bytes(b"not read")  # before the points have had their say
    refused = registered(command, block, cameras, films, *given, f"out={tmp_path / 'no'}")
    assert refused.code == 2 and "could not be brought to the points" in refused.err
    assert "cloud.ply" in refused.err and not (tmp_path / "no").exists()


def test_the_lamp_s_time_is_found_in_the_frames(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    rooms = under_a_lamp(films, 0.8, tmp_path)
    out = tmp_path / "scene"
    words = (f"out={out}", LAMP, "find_lamp_time=true")
    outcome = registered(command, block, cameras, rooms, *words)
    assert outcome.code == 0, outcome.err
    recording = read_scene(out).runs["recording"].recording
    # Frames are half a second apart, and the first of all is 9 s before the lamp.
    assert recording.quiet is not None
    start = recording.time[0] - 0.5 * len(recording.quiet)
    assert start == pytest.approx(-9.0, abs=0.05)
    refused = registered(command, block, cameras, rooms, f"out={out}", "find_lamp_time=true")
    assert refused.code == 2 and "no lamp whose time" in refused.err


def test_counts_become_temperatures_by_the_maker_s_constants(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    constants = PlanckConstants(r1=16000.0, r2=0.012, b=1420.0, f=1.0, o=-7000.0)
    optics = Optics(0.9, 290.0)
    plain = tmp_path / "plain"
    assert registered(command, block, cameras, films, f"out={plain}").code == 0
    for film in films:
        with np.load(film) as held:
            counts = measured_signal(constants, optics, held["frames"].astype(float))
            np.savez(film, time=held["time"], frames=counts, unit="counts")
    out = tmp_path / "counted"
    grey = ("optics.emissivity=0.9", "optics.reflected_temperature=290")
    planck = "optics.planck={r1:16000,r2:0.012,b:1420,f:1,o:-7000}"
    outcome = registered(command, block, cameras, films, f"out={out}", *grey, planck)
    assert outcome.code == 0, outcome.err
    first, second = (read_scene(one).runs["recording"].recording for one in (plain, out))
    # Counts in single precision hold some millikelvin.
    np.testing.assert_allclose(first.temperature, second.temperature, atol=0.01)
    refused = registered(command, block, cameras, films, f"out={tmp_path / 'no'}", *grey)
    assert refused.code == 2 and "optics.planck" in refused.err
    refused = registered(command, block, cameras, films, f"out={tmp_path / 'no'}", planck)
    assert refused.code == 2 and "the emissivity is missing" in refused.err


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("optics.emissivity=0.9", "optics.planck={r1:1}"), "no constants of Planck's law"),
        (("align=shape",), "no such alignment"),
        (("ambient_temperature=22",), "add 273.15"),
        (("heater={centre:[0,0,0]}",), "this is no lamp"),
        (("material.density=null",), "material.density"),
        (("samples.grazing=120",), "grazing"),
        (("camera_axes=blender",), "these axes are not known"),
        (("camera_axes=opencv",), "the other convention"),
        (("camera_scale=1000",), "camera_scale=0.001"),
        (("optics.emissivity=92",), "divide by 100"),
        (("optics.reflected_temperature=295",), "the emissivity is missing"),
        (("unit=ft",), "unit is not known"),
        (("scene=nowhere",), "nowhere"),
        (("run=a/b",), "unusable name"),
        (("initial_temperature=0",), "initial_temperature"),
        (("together=-1",), "together"),
        (("together=soon",), "time between frames [s] is not a number"),
        (("held_out=perhaps",), "held_out: this is neither yes nor no"),
        (("find_lamp_time=1",), "find_lamp_time: this is neither yes nor no"),
        (("recording.faults=some",), "recording.faults: this is neither yes nor no"),
        (("recording.rate=0",), "recording: rate"),
        (("recording.times=nowhere.txt",), "recording.times: these times cannot be read"),
        (("recording.times=[1,0]",), "recording: times"),
        (("recording.times=[0,1]", "recording.rate=2"), "times and rate"),
        (("camera_scale=0",), "camera_scale: length of the cameras' unit [m] is out of range"),
        (("camera_scale=mm",), "camera_scale: length of the cameras' unit [m] is not a number"),
        (("samples.count=0",), "samples.count"),
        (("samples.margin=1.5",), "samples.margin"),
    ],
)
def test_what_cannot_be_is_told_before_frames_are_read(
    command: Command, block: Path, cameras: Path, tmp_path: Path, more: tuple[str, ...], words: str
) -> None:
    blank = tmp_path / "blank.npz"
    blank.write_bytes(b"not read")
    out = tmp_path / "scene"
    outcome = registered(command, block, cameras, [blank, blank], f"out={out}", *more)
    assert outcome.code == 2 and not out.exists()
    assert words in outcome.err, outcome.err


def test_frames_that_do_not_fit_leave_nothing(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    out = tmp_path / "scene"
    outcome = registered(command, block, cameras, films[:1], f"out={out}")
    assert outcome.code == 2 and "1 recordings, 2 cameras" in outcome.err
    small = tmp_path / "small.npz"
    np.savez(small, time=np.arange(3.0), frames=np.full((3, 72, 90), 300.0))
    outcome = registered(command, block, cameras, [films[0], small], f"out={out}")
    assert outcome.code == 2 and "90 x 72" in outcome.err and "96 x 72" in outcome.err
    films[0].write_bytes(films[0].read_bytes()[:3000])
    outcome = registered(command, block, cameras, films, f"out={out}")
    assert outcome.code == 2 and str(films[0]) in outcome.err
    assert not out.exists()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("formats=[avi]",), "no such film"),
        (("degrees=F",), "no such degrees"),
        (("colours=rainbow",), "no such colour map"),
        (("run=other",), "unknown run"),
        (("every=0",), "1 or more"),
        (("nearest=0",), "nearest"),
        (("nearest=all",), "nearest"),
        (("nearest=100000",), "the samples of run lamp"),
        (("rate=fast",), "rate"),
        (("camera_axes=opencv",), "out of this camera's view"),
    ],
)
def test_a_render_that_makes_no_sense_is_refused(
    command: Command, block: Path, cameras: Path, tmp_path: Path, more: tuple[str, ...], words: str
) -> None:
    out = tmp_path / "films"
    given = {"data": block, "run": "lamp", "cameras": cameras, "out": out}
    given |= dict(one.split("=", 1) for one in more)
    outcome = command("render", *(f"{key}={value}" for key, value in given.items()))
    assert outcome.code == 2 and words in outcome.err, outcome.err
    assert not [one for one in out.glob("*") if out.exists()]


def test_a_surface_out_of_place_and_a_scene_that_is_replaced_are_told_of(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    stated = read_scene(block)
    right = read_surface(stated.surface_path, unit=stated.unit)
    moved = trimesh.Trimesh(right.vertices + [0.002, 0.001, 0.0], right.triangles, process=False)
    moved.export(tmp_path / "off.ply")
    rooms, out = under_a_lamp(films, 0.0, tmp_path), tmp_path / "scene"
    outcome = registered(command, block, cameras, rooms, f"out={out}")
    assert outcome.code == 0, outcome.err
    assert "OUT OF PLACE?" not in outcome.out and "was replaced" not in outcome.out
    own = read_scene(out).surface_path
    kept = own.rename(own.with_name("stood.ply"))
    record = json.loads((out / "scene.json").read_text("utf-8")) | {"surface": kept.name}
    (out / "scene.json").write_text(json.dumps(record), encoding="utf-8")
    words = (f"surface={tmp_path / 'off.ply'}", "unit=m", f"out={out}")
    outcome = registered(command, block, cameras, rooms, *words)
    assert outcome.code == 0, outcome.err
    assert "OUT OF PLACE?" in outcome.out and "align=pose" in outcome.out
    assert f"the scene that stood in {out} was replaced" in outcome.out
    assert "stood.ply still lies there and is not used" in outcome.out


def test_recordings_in_another_order_are_told_of(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    out = tmp_path / "scene"
    outcome = registered(command, block, cameras, films[::-1], f"out={out}")
    assert outcome.code == 0, outcome.err
    told = json.loads((out / "recording+registration.json").read_text("utf-8"))["told"]
    words = [one for one in told if "WRONG ORDER?" in one]
    assert len(words) == 1 and words == told[-1:] and words[0] in outcome.out
    assert f"front {films[0]}, back {films[1]}" in words[0]


def test_times_that_no_file_holds_are_stated(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    time = np.array([-1.0, 0.0, 0.5, 2.0])
    bare = [tmp_path / f"{film.stem}.npy" for film in films]
    for film, file in zip(films, bare, strict=True):
        with np.load(film) as held:
            np.save(file, held["frames"][[0, 1, 3, 6]])
    listed = tmp_path / "times.txt"
    listed.write_text("# s\n" + "\n".join(map(str, time)) + "\n")
    for number, stated in enumerate((f"[{','.join(map(str, time))}]", str(listed))):
        out = tmp_path / f"scene_{number}"
        outcome = registered(
            command, block, cameras, bare, f"out={out}", "recording.unit=K",
            f"recording.times={stated}",
        )  # fmt: skip
        assert outcome.code == 0, outcome.err
        recording = read_scene(out).runs["recording"].recording
        np.testing.assert_array_equal(recording.time, time[1:])
        assert recording.quiet is not None and len(recording.quiet) == 1
    out = tmp_path / "none"
    outcome = registered(command, block, cameras, bare, f"out={out}", "recording.unit=K")
    assert outcome.code == 2 and "recording.times" in outcome.err
    short = ("recording.unit=K", "recording.times=[0,1]")
    outcome = registered(command, block, cameras, bare, f"out={out}", *short)
    assert outcome.code == 2 and "frames and times differ in number" in outcome.err


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_photographs_that_the_cameras_file_names_are_no_frames(
    command: Command, block: Path, tmp_path: Path, suffix: str
) -> None:
    files = {name: f"{name}{suffix}" for name in PLACES}
    for file in files.values():
        Image.new("RGB", (96, 72), (200, 100, 50)).save(tmp_path / file)
    write_transforms(tmp_path / "photographs.json", views(files))
    out = tmp_path / "scene"
    words = [
        f"cameras={tmp_path / 'photographs.json'}", f"surface={read_scene(block).surface_path}",
        "unit=mm", f"out={out}", "initial_temperature=295", *MATERIAL,
    ]  # fmt: skip
    outcome = command("register", *words)
    assert outcome.code == 2 and not out.exists()
    assert f"front{suffix}" in outcome.err
    assert "where that is a photograph, name the thermal recordings by frames=" in outcome.err


def test_cameras_that_name_no_recording_want_frames(
    command: Command, block: Path, cameras: Path, tmp_path: Path
) -> None:
    out = tmp_path / "scene"
    words = [
        f"cameras={cameras}", f"surface={read_scene(block).surface_path}", "unit=mm",
        f"out={out}", "initial_temperature=295", *MATERIAL,
    ]  # fmt: skip
    outcome = command("register", *words)
    assert outcome.code == 2 and not out.exists()
    assert "these cameras name no recording" in outcome.err and "front, back" in outcome.err


def test_a_camera_that_moves_takes_one_picture_a_pose(
    command: Command, block: Path, cameras: Path, films: list[Path], tmp_path: Path
) -> None:
    moving = []
    for view, film in zip(views(), films, strict=True):
        with np.load(film) as held:
            for number in (0, 5, 10):
                file = f"{view.camera.name}_{number}.npy"
                np.save(tmp_path / file, held["frames"][number][None])
                moving.append(View(view.camera, file, float(held["time"][number])))
    write_transforms(tmp_path / "moving.json", moving)
    out = tmp_path / "scene"
    words = [
        f"cameras={tmp_path / 'moving.json'}", f"surface={read_scene(block).surface_path}",
        "unit=mm", f"out={out}", "initial_temperature=295", "recording.unit=K", *MATERIAL,
    ]  # fmt: skip
    outcome = command("register", *words)
    assert outcome.code == 0, outcome.err
    recording = read_scene(out).runs["recording"].recording
    np.testing.assert_allclose(recording.time, [0.0, 7.5, 15.0])
    assert recording.valid.all() and np.ptp(recording.temperature[2]) > 1.0
