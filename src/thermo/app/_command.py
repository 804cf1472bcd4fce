"""The `thermo` command: picks the verb and hands the rest to Hydra."""

from __future__ import annotations

import gc
import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

from thermo import errors
from thermo.app import _verbs
from thermo.app._discover import discover
from thermo.app._identify import identify
from thermo.app._others_results import keep_others_results
from thermo.app._reconstruct import reconstruct_surface
from thermo.app._register import register
from thermo.app._render import render_run
from thermo.app._sweep import WORDS, finished, job_folder

VERBS: Mapping[str, Callable[[Mapping[str, Any]], None]] = {
    "discover": discover,
    "ensemble": _verbs.ensemble,
    "identify": identify,
    "invert": _verbs.invert,
    "predict": _verbs.predict,
    "reconstruct": reconstruct_surface,
    "register": register,
    "render": render_run,
    "simulate": _verbs.simulate,
    "study": _verbs.study,
}

RESUMED = ("discover", "invert", "reconstruct", "render", "study")
"""Verbs that go on where they were stopped."""

STUDIES = ("paper",)
"""What can be studied."""

HELP = """thermo VERB key=value ...

  thermo invert data=FOLDER runs=[a,b] unknown=[conductivity] field=NAME optimiser=NAME out=DIR
  thermo predict data=FOLDER estimate=DIR runs=[c] out=DIR
  thermo simulate data=FOLDER run=a material.conductivity=0.2 out=DIR
  thermo ensemble folder=DIR
  thermo identify data=FOLDER estimate=DIR out=DIR
  thermo discover data=FOLDER out=DIR
  thermo reconstruct cameras=transforms.json images=FOLDER out=DIR
  thermo render data=FOLDER run=a cameras=transforms.json out=DIR
  thermo register frames=[a,b] cameras=transforms.json surface=FILE out=FOLDER
  thermo study paper data=SCENES size=quick out=DIR

`thermo VERB --help` shows every setting; -m runs all combinations of values joined by commas.
`thermo --version` prints the version.
"""


def configuration_folder() -> Path:
    """Folder of the configuration: in the installed package, or at the root of the repository."""
    inside = Path(errors.__file__).parent / "conf"
    return inside if inside.is_dir() else Path(errors.__file__).parents[2] / "conf"


def _settings(configuration: DictConfig) -> dict[str, Any]:
    settings = OmegaConf.to_container(configuration, resolve=True, throw_on_missing=True)
    assert isinstance(settings, dict)
    job = HydraConfig.get()
    if job.mode == RunMode.MULTIRUN:
        # Jobs of a multirun never share a folder.
        folder = job_folder(Path(str(settings["out"])), job.overrides.task, job.job.num)
        settings["out"] = str(folder)
    return {str(key): value for key, value in settings.items()}


def _refusal(verb: str, fault: Exception) -> errors.InputError:
    """What Hydra says of a command line, without its search path."""
    found, _, rest = str(fault).partition("\n")
    if isinstance(fault, MissingMandatoryValue) and fault.full_key:
        return _missing(verb, str(fault.full_key), found)
    options = rest.partition("Available options in")[2].partition("Config search path")[0]
    listed = [line.strip() for line in options.splitlines()[1:] if line.strip()]
    unknown = re.search("override '([^']+)'", found)
    names = _names(verb) if unknown else []
    meant = errors.meant(unknown[1], names) if unknown else ""
    bare = re.search("parsing override '([^'=]+)'", found)
    if bare and "data" in names:
        # A word without a name is a folder as a rule.
        meant = f"write data={bare[1]} if that is the folder of the data; "
    if several := re.search("Ambiguous value for argument '([^'=]+)=([^']*)'", found):
        meant = f"write '{several[1]}=[{several[2]}]' for a list, or add -m to run each; "
    own = dict.fromkeys(name.partition(".")[0] for name in names)
    limit = listed or [name for name in own if name not in ("defaults", "hydra")]
    return errors.InputError(
        "this command line cannot be used",
        where="the words after the verb",
        value=found,
        limit=", ".join(limit) or f"the settings of conf/{verb}.yaml, each with a value",
        remedy=f"{meant}`thermo {verb} --help` shows every setting and its choices",
    )


def _names(verb: str) -> list[str]:
    """Names of all settings of a verb, those of groups with dots."""
    folder = configuration_folder()
    known = OmegaConf.load(folder / f"{verb}.yaml")
    names = [*_keys(known)]
    for group, option in (pair for one in known.defaults for pair in _groups(one)):
        names += [group, *_keys(OmegaConf.load(folder / group / f"{option}.yaml"), f"{group}.")]
    return names


def _groups(default: Any) -> Iterator[tuple[str, str]]:
    """The group and the option that an entry of a list of defaults names, if it does."""
    if isinstance(default, DictConfig):
        yield from (
            (str(g), str(o)) for g, o in default.items() if not str(g).startswith("override")
        )


def _keys(section: Any, before: str = "") -> Iterator[str]:
    """All names of settings in a section of a file of settings, those of its parts with dots."""
    for key, value in section.items_ex(resolve=False):
        yield f"{before}{key}"
        if isinstance(value, DictConfig):
            yield from _keys(value, f"{before}{key}.")


def _missing(verb: str, key: str, found: str) -> errors.InputError:
    """A setting without a value, with what its file says of it: meaning and unit."""
    text = (configuration_folder() / f"{verb}.yaml").read_text("utf-8")
    meaning = re.search(rf"^{re.escape(key)}: \?\?\? *# *(.+)$", text, re.MULTILINE)
    return errors.InputError(
        "a setting has no value", where=key, value=found,
        limit=f"{meaning[1] if meaning else 'a value'} (conf/{verb}.yaml)",
        remedy=f"give {key}=VALUE; `thermo {verb} --help` shows every setting",
    )  # fmt: skip


# Tracing makes millions of short-lived objects beside hundreds of thousands that live on, through
# which Python's collector would look again and again.
_SELDOM = (20_000, 20, 20)


def _run(verb: str, configuration: DictConfig) -> None:
    gc.set_threshold(*_SELDOM)
    try:
        settings = _settings(configuration)
        if HydraConfig.get().mode == RunMode.MULTIRUN and finished(verb, settings):
            print(f"{settings['out']}: finished before; remove it to run it anew", file=sys.stderr)
            return
        keep_others_results(verb, Path(str(settings.get("out"))))
        VERBS[verb](settings)
    except errors.InputError as fault:
        print(f"thermo {verb}: {fault}", file=sys.stderr)
        sys.exit(2)
    except OmegaConfBaseException as fault:
        print(f"thermo {verb}: {_refusal(verb, fault)}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        after = "goes on from what was saved" if verb in RESUMED else "begins anew"
        print(f"thermo {verb}: stopped; the same command {after}", file=sys.stderr)
        sys.exit(130)


def _named_study(words: list[str]) -> list[str]:
    """The words of `thermo study NAME key=value ...` without the name."""
    name = words[1] if len(words) > 1 else ""
    if name not in STUDIES and name not in ("-h", "--help"):
        known = f"give the name of a study: {', '.join(STUDIES)}"
        print(f"thermo study: {known}, and not {name!r}" if name else known, file=sys.stderr)
        sys.exit(2)
    return [words[0], *words[2:]] if name in STUDIES else words


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
    words = _named_study(words) if verb == "study" else words
    sys.argv = [f"thermo {verb}", *words[1:]]
    os.environ[WORDS] = json.dumps(words[1:])
    folder = str(configuration_folder())
    task = hydra.main(version_base="1.3", config_path=folder, config_name=verb)
    # Hydra then leaves its exceptions to us; its own report ends with another exit code.
    os.environ["HYDRA_FULL_ERROR"] = "1"
    try:
        task(lambda configuration: _run(verb, configuration))()
    except (HydraException, OmegaConfBaseException) as fault:
        print(f"thermo {verb}: {_refusal(verb, fault)}", file=sys.stderr)
        sys.exit(2)
    except OSError as fault:
        # A full disk, or a folder that Hydra could not make for a multirun.
        refusal = errors.InputError(
            "a file or folder cannot be used",
            where=str(fault.filename or "out"),
            value=fault.strerror or str(fault),
            limit="folders that can be made and written to, with room left",
            remedy="make room, or give another folder with out=FOLDER",
        )
        print(f"thermo {verb}: {refusal}", file=sys.stderr)
        sys.exit(2)
