"""Programs: how they are compiled, and kept on disk for the next run of their kind."""

from __future__ import annotations

import functools
import hashlib
import os
import platform
import threading
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Any, Final, ParamSpec, TypeVar, cast, final

import equinox as eqx
import jax
import jax.numpy as jnp

from thermo._cache_folder import cache_folder

Taken = ParamSpec("Taken")
Given = TypeVar("Given")

# A simulation is some hundred small loops. XLA writes each by way of MLIR, which takes about as
# long as optimising it; the way before that takes up to a third off compiling, and programs run as
# fast (`benchmarks/compiling.py`).
_OPTIONS: Final[dict[str, Any]] = {"xla_cpu_use_fusion_emitters": False}

SHORTEST = 0.3
"""Seconds of compiling from which a program is kept."""


def _machine() -> str:
    """A name for this kind of processor: programs for another one may not run here."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    features = next((line for line in lines if line.lower().startswith(("flags", "features"))), "")
    return f"{platform.machine()}-{hashlib.sha256(features.encode()).hexdigest()[:12]}"


def compiled_cache() -> Path:
    """`compiled` in the user's cache, by kind of processor."""
    return cache_folder() / "compiled" / _machine()


def keep_compiled() -> None:
    """Let JAX keep what it compiles; a folder that the user chose for it, or none, stays.

    $JAX_ENABLE_COMPILATION_CACHE=false turns it off. A folder that cannot be written is passed
    over.
    """
    chosen = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue]
    if chosen is not None:
        return
    try:
        folder = compiled_cache()
        # It is made when there is a program to keep, not by an import.
        there = next(place for place in (folder, *folder.parents) if place.exists())
    except (OSError, RuntimeError):
        return
    if there.is_dir() and os.access(there, os.W_OK):
        jax.config.update("jax_compilation_cache_dir", str(folder))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", SHORTEST)


@functools.cache
def _options() -> dict[str, Any]:
    """What programs are compiled with, as far as this XLA knows it."""
    try:
        jax.jit(lambda: 0.0).lower().compile(compiler_options=_OPTIONS)
    except jax.errors.JaxRuntimeError:
        return {}
    return _OPTIONS


def program(
    function: Callable[Taken, Given], compiled_with: Callable[[], dict[str, Any]] = _options
) -> Callable[Taken, Given]:
    """The function as `equinox.filter_jit` compiles it, only sooner, and once for all threads.

    Numbers whose type JAX takes for weak, as those made from Python's are, get it for good: they
    would ask for a program of their own. Not to be called while another program is traced: what it
    is `compiled_with` is for a whole program.
    """

    # Asked for when it first runs: what XLA knows it says by compiling.
    @functools.cache
    def made() -> Callable[Taken, Given]:
        # Its types know of no options; what it does not take itself it hands on to `jax.jit`.
        return cast(Any, eqx.filter_jit)(function, compiler_options=compiled_with())

    @functools.wraps(function)
    def run(*args: Taken.args, **kwargs: Taken.kwargs) -> Given:
        taken = jax.tree.map(_strong, (args, kwargs))
        key = (function, *_kind(taken))
        with _giving_turns:
            compiles, turn = cast(Any, made()), _turns.setdefault(key, _Turn())
        if turn.compiled:
            return compiles(*taken[0], **taken[1])
        with turn.lock:
            given = compiles(*taken[0], **taken[1])
            turn.compiled = True
        return given

    return run


def _strong(leaf: Any) -> Any:
    return jnp.asarray(leaf, leaf.dtype) if isinstance(leaf, jax.Array) and leaf.weak_type else leaf


@final
class _Turn:
    """A program that a thread compiles, for which others that need the same one wait.

    JAX lets each of them compile it, as two runs of one shape do side by side.
    """

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.compiled = False


_turns: dict[Hashable, _Turn] = {}
_giving_turns = threading.Lock()


def _kind(taken: Any) -> tuple[Hashable, ...]:
    """What tells programs of one function apart: shapes of arrays, and all that is no array."""
    leaves, tree = jax.tree.flatten(taken)
    kinds = [(leaf.shape, leaf.dtype) if eqx.is_array(leaf) else leaf for leaf in leaves]
    return tree, *kinds


MOST_MAPS = 0.5
"""Share of the memory maps that the system allows a process, from which programs are dropped."""


def make_room() -> None:
    """Drop the compiled programs in memory when they have come near what the system allows.

    Every program takes memory maps and keeps them. A process that fits one body after the other, or
    searches for one effect after the other, would come to the limit, after which nothing compiles:
    "LLVM compilation error: Cannot allocate memory". What is needed again comes from the folder on
    disk. Elsewhere than on Linux there is no such limit.
    """
    try:
        limit = int(Path("/proc/sys/vm/max_map_count").read_text(encoding="ascii"))
        with open("/proc/self/maps", "rb") as maps:
            used = sum(1 for _ in maps)
    except (OSError, ValueError):
        return
    if used > MOST_MAPS * limit:
        jax.clear_caches()
        _turns.clear()
