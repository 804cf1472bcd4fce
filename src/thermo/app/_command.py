"""The `thermo` command: picks the verb and hands the rest to Hydra."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

import thermo
from thermo.app import _verbs
from thermo.errors import InputError

VERBS: Mapping[str, Callable[[Mapping[str, Any]], None]] = {
    "invert": _verbs.invert,
    "predict": _verbs.predict,
    "simulate": _verbs.simulate,
}

HELP = """thermo VERB key=value ...

  thermo invert data=FOLDER runs=[a,b] unknown=[conductivity] field=NAME optimiser=NAME out=DIR
  thermo predict data=FOLDER estimate=DIR runs=[c] out=DIR
  thermo simulate data=FOLDER run=a material.conductivity=0.2 out=DIR

`thermo VERB --help` shows every setting; -m runs all combinations of values joined by commas.
`thermo --version` prints the version.
"""


def configuration_folder() -> Path:
    """Folder of the configuration: in the installed package, or at the root of the repository."""
    inside = Path(thermo.__file__).parent / "conf"
    return inside if inside.is_dir() else Path(thermo.__file__).parents[2] / "conf"


def _settings(configuration: DictConfig) -> dict[str, Any]:
    settings = OmegaConf.to_container(configuration, resolve=True, throw_on_missing=True)
    assert isinstance(settings, dict)
    job = HydraConfig.get()
    if job.mode == RunMode.MULTIRUN:
        # Jobs of a multirun never share a folder.
        label = job.job.override_dirname.replace("/", "_") or str(job.job.num)
        settings["out"] = str(Path(str(settings["out"])) / label)
    return {str(key): value for key, value in settings.items()}


def _run(verb: str, configuration: DictConfig) -> None:
    try:
        VERBS[verb](_settings(configuration))
    except InputError as fault:
        print(f"thermo {verb}: {fault}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print(f"thermo {verb}: stopped; the same command goes on from there", file=sys.stderr)
        sys.exit(130)


def main() -> None:
    """Entry point of the console script."""
    words = sys.argv[1:]
    if words[:1] == ["--version"]:
        print(version("thermofield"))
        return
    if not words or words[0] not in VERBS:
        asked = not words or words[0] in ("-h", "--help", "help")
        stream = sys.stdout if asked else sys.stderr
        if not asked:
            print(f"thermo: there is no verb {words[0]!r}\n", file=stream)
        print(HELP, file=stream, end="")
        sys.exit(0 if asked else 2)
    verb = words[0]
    sys.argv = [f"thermo {verb}", *words[1:]]
    folder = str(configuration_folder())
    task = hydra.main(version_base="1.3", config_path=folder, config_name=verb)
    task(lambda configuration: _run(verb, configuration))()
