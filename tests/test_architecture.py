"""The rules of the house, checked on the source: order of the rooms, sizes, classes, docstrings."""

from __future__ import annotations

import ast
import re
import statistics
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "thermo"
ROOMS = (
    "errors",
    "mesh",
    "fields",
    "physics",
    "observe",
    "imaging",
    "reconstruct",
    "inverse",
    "identify",
    "discover",
    "report",
    "study",
    "app",
)
# Modules at the top that belong to no room: what they may import is what stands left of the rank.
TOP = dict.fromkeys(("_cache_folder", "_duration", "_say", "_remembered"), -1)
TOP |= {"_compiled": 0, "_conflict": 0}
TOP |= dict.fromkeys(("__init__", "__main__"), len(ROOMS))
SILENT = ROOMS[: ROOMS.index("report")]
WITH_UNITS = SILENT[1:]

Function = ast.FunctionDef | ast.AsyncFunctionDef


def name_of(path: Path) -> str:
    """Dotted name of a module, `thermo.mesh._box` or, for an `__init__`, `thermo.mesh`."""
    parts = path.relative_to(SOURCE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


PATHS = {name_of(path): path for path in sorted(SOURCE.rglob("*.py"))}
TREES = {name: ast.parse(path.read_text("utf-8")) for name, path in PATHS.items()}


def room_of(name: str) -> str:
    parts = name.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def rank(room: str) -> int:
    return TOP[room] if room in TOP else ROOMS.index(room)


def from_module(name: str, node: ast.ImportFrom) -> str:
    """The absolute name of the module that `from ... import` in the module `name` means."""
    if node.level == 0:
        return node.module or ""
    package = name.split(".")
    if PATHS[name].name != "__init__.py":
        package = package[:-1]
    package = package[: len(package) - node.level + 1]
    return ".".join([*package, node.module] if node.module else package)


def imports(name: str) -> Iterator[tuple[int, str]]:
    """Line and absolute name of everything of ours that a module imports."""
    for node in ast.walk(TREES[name]):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            module = from_module(name, node)
            found = [module]
            if module == "thermo":
                inner = [f"thermo.{alias.name}" for alias in node.names]
                found = [n if room_of(n) in ROOMS else "thermo" for n in inner]
        else:
            continue
        for other in found:
            if other.split(".")[0] == "thermo":
                yield node.lineno, other


def functions(tree: ast.AST) -> Iterator[Function]:
    return (n for n in ast.walk(tree) if isinstance(n, Function))


def classes(tree: ast.AST) -> Iterator[ast.ClassDef]:
    return (n for n in ast.walk(tree) if isinstance(n, ast.ClassDef))


def last_name(node: ast.expr) -> str:
    """`AbstractField` of `AbstractField`, `fields.AbstractField` or `AbstractField[T]`."""
    if isinstance(node, ast.Subscript | ast.Call):
        return last_name(node.value if isinstance(node, ast.Subscript) else node.func)
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def decorators(node: Function | ast.ClassDef) -> set[str]:
    return {last_name(d) for d in node.decorator_list}


def public_names(name: str) -> list[str]:
    for node in TREES[name].body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(isinstance(t, ast.Name) and t.id == "__all__" for t in targets):
                return list(ast.literal_eval(node.value))
    return []


def definition(name: str, public: str) -> tuple[str, ast.stmt] | None:
    """Where a public name is defined: follows imports through our modules."""
    for node in TREES[name].body:
        if isinstance(node, ast.ClassDef | Function) and node.name == public:
            return name, node
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(isinstance(t, ast.Name) and t.id == public for t in targets):
                return name, node
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                if (alias.asname or alias.name) == public:
                    module = from_module(name, node)
                    if f"{module}.{alias.name}" in TREES:
                        return None
                    return definition(module, alias.name) if module in TREES else None
    return None


def exported() -> list[tuple[str, str]]:
    return [(name, public) for name in TREES for public in public_names(name)]


def listed(wrong: list[str]) -> list[str]:
    """What a failure shows."""
    return sorted(set(wrong))


def test_every_module_stands_in_a_room() -> None:
    unknown = [n for n in TREES if room_of(n) not in ROOMS and room_of(n) not in TOP]
    assert not listed(unknown)
    assert {room_of(n) for n in TREES} >= {"errors"}


def test_a_module_imports_only_from_its_left() -> None:
    wrong = [
        f"{name}:{line} imports {other}"
        for name in TREES
        for line, other in imports(name)
        if room_of(other) != room_of(name) and rank(room_of(other)) >= rank(room_of(name))
    ]
    assert not listed(wrong)


def test_importing_the_package_does_not_import_the_command() -> None:
    wrong = [other for _, other in imports("thermo") if room_of(other) == "app"]
    assert not listed(wrong)


def test_modules_are_small() -> None:
    sizes = {name: len(path.read_text("utf-8").splitlines()) for name, path in PATHS.items()}
    assert not {name: size for name, size in sizes.items() if size > 450}
    assert statistics.median(sizes.values()) < 150


def test_functions_are_short() -> None:
    long = [
        f"{name}.{node.name}: {length} lines"
        for name, tree in TREES.items()
        for node in functions(tree)
        if (length := (node.end_lineno or 0) - node.lineno + 1) > 60
    ]
    assert not listed(long)


def test_no_module_is_called_utils() -> None:
    vague = {"util", "utils", "helper", "helpers", "common", "misc"}
    assert not [name for name in TREES if vague & {p.strip("_") for p in name.split(".")}]


def is_exempt(node: ast.ClassDef) -> bool:
    bases = {last_name(base) for base in node.bases}
    plain = {"Protocol", "NamedTuple", "TypedDict"}
    return bool(bases & plain) or any(b.endswith(("Error", "Exception", "Warning")) for b in bases)


def test_every_class_is_abstract_or_final() -> None:
    wrong = [
        f"{name}.{node.name}"
        for name, tree in TREES.items()
        for node in classes(tree)
        if not node.name.lstrip("_").startswith("Abstract")
        and not is_exempt(node)
        and "final" not in decorators(node)
    ]
    assert not listed(wrong)


def ancestors(name: str, node: ast.ClassDef) -> Iterator[tuple[str, ast.ClassDef]]:
    for base in node.bases:
        found = definition(name, last_name(base))
        if found is not None and isinstance(found[1], ast.ClassDef):
            yield found[0], found[1]
            yield from ancestors(found[0], found[1])


def methods(node: ast.ClassDef) -> dict[str, Function]:
    return {n.name: n for n in node.body if isinstance(n, Function)}


def overridden(name: str, node: ast.ClassDef) -> list[str]:
    """Concrete methods of ancestors of ours that a class defines anew.

    Equinox calls the `__check_init__` of every ancestor, so that one adds and does not override.
    """
    mine = set(methods(node)) - {"__check_init__"}
    return [
        f"{name}.{node.name}.{method} overrides {parent}.{ancestor.name}"
        for parent, ancestor in ancestors(name, node)
        for method, definition_ in methods(ancestor).items()
        if method in mine and not any("abstract" in d for d in decorators(definition_))
    ]


def test_no_class_overrides_a_concrete_method() -> None:
    wrong = [
        w for name, tree in TREES.items() for node in classes(tree) for w in overridden(name, node)
    ]
    assert not listed(wrong)


def test_no_final_class_has_a_child() -> None:
    wrong = [
        f"{name}.{node.name} inherits from {ancestor.name}"
        for name, tree in TREES.items()
        for node in classes(tree)
        for _, ancestor in ancestors(name, node)
        if "final" in decorators(ancestor)
    ]
    assert not listed(wrong)


def has_text(name: str, node: ast.stmt) -> bool:
    """A docstring; for a constant also a string below it or a comment above or beside it."""
    if isinstance(node, ast.ClassDef | Function):
        return bool(ast.get_docstring(node))
    body = TREES[name].body
    after = body[body.index(node) + 1 : body.index(node) + 2]
    if after and isinstance(after[0], ast.Expr) and isinstance(after[0].value, ast.Constant):
        return True
    lines = PATHS[name].read_text("utf-8").splitlines()
    above = lines[node.lineno - 2] if node.lineno > 1 else ""
    last = lines[(node.end_lineno or node.lineno) - 1]
    return above.lstrip().startswith("#") or "  # " in last


def test_every_public_name_has_a_docstring() -> None:
    wrong = []
    for name, public in exported():
        found = definition(name, public)
        if found is not None and not has_text(*found):
            wrong.append(f"{found[0]}.{public}")
    assert not listed(wrong)


def test_every_room_states_its_public_names() -> None:
    rooms = [n for n in TREES if n.count(".") == 1 and PATHS[n].name == "__init__.py"]
    assert not [name for name in rooms if not public_names(name)]


UNITS = {
    "1", "m", "mm", "cm", "inch", "kg", "s", "K", "J", "W", "rad", "deg", "px", "Hz", "mol",
}  # fmt: skip
# What a caller may hand over as one number with a unit, once whole-number arrays are taken out.
COUNTS = re.compile(r"\b(Int|Integer|UInt|Bool|Shaped|Key|Int32|Int64)\[[^\[\]]*\]")
NUMBERS = re.compile(r"\b(float|Float|Float32|Float64|Inexact|Array|ArrayLike|ndarray)\b")


def names_a_unit(text: str) -> bool:
    """Whether brackets hold an SI unit: [m], [1], [W/m/K], [W/(m K)], [m^2/s], [J m-3 K-1].

    A field of any quantity carries its unit with it, and says so in these words.
    """
    if "quantity's unit" in " ".join(text.split()):
        return True
    for inside in re.findall(r"\[([^\[\],]+)\]", text):
        words = re.split(r"[\s/*·.()^⁻⁰¹²³⁴-]+|sqrt", inside)
        symbols = [re.sub(r"(?<=[A-Za-z])\d$", "", w) for w in words if w]
        if inside.strip() == "1":
            return True
        letters = [s for s in symbols if not s.isdigit()]
        if letters and all(s in UNITS for s in letters):
            return True
    return False


def carries_numbers(node: Function) -> bool:
    arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    notes = [a.annotation for a in arguments] + [node.returns]
    text = " ".join(ast.unparse(n) for n in notes if n is not None)
    return NUMBERS.search(COUNTS.sub("", text)) is not None


def test_public_functions_state_units() -> None:
    wrong = []
    for name, public in exported():
        found = definition(name, public)
        if found is None or room_of(found[0]) not in WITH_UNITS:
            continue
        module, node = found
        if isinstance(node, Function) and carries_numbers(node):
            if not names_a_unit(ast.get_docstring(node) or ""):
                wrong.append(f"{module}.{public}")
    assert not listed(wrong)


@pytest.mark.parametrize(
    "text", ["[m]", "a [1] b", "[W/m/K]", "[W/(m K)]", "[m^2/s]", "[m2/s]", "[J m-3 K-1]", "[W/m²]"]
)
def test_units_are_recognised(text: str) -> None:
    assert names_a_unit(text)


@pytest.mark.parametrize("text", ["none", "[0, 1]", "(m)", "[nodes]", "[3]", "points[k]", "[]"])
def test_other_brackets_are_not_units(text: str) -> None:
    assert not names_a_unit(text)


def calls(tree: ast.AST) -> Iterator[ast.Call]:
    return (n for n in ast.walk(tree) if isinstance(n, ast.Call))


def test_nothing_is_unpickled_or_evaluated() -> None:
    wrong = []
    loaders = {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal", "shelve"}
    for name, tree in TREES.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Import | ast.ImportFrom):
                module = getattr(node, "module", None) or ""
                roots = {a.name.split(".")[0] for a in node.names} | {module.split(".")[0]}
                wrong += [f"{name}:{node.lineno} imports {bad}" for bad in roots & loaders]
        for call in calls(tree):
            if isinstance(call.func, ast.Name) and call.func.id in {"eval", "exec"}:
                wrong.append(f"{name}:{call.lineno} calls {call.func.id}")
            for key in call.keywords:
                if key.arg == "allow_pickle" and getattr(key.value, "value", True) is not False:
                    wrong.append(f"{name}:{call.lineno} allows pickles")
    assert not listed(wrong)


def test_the_computing_rooms_do_not_print() -> None:
    wrong = [
        f"{name}:{call.lineno}"
        for name, tree in TREES.items()
        if room_of(name) in SILENT
        for call in calls(tree)
        if isinstance(call.func, ast.Name) and call.func.id == "print"
    ]
    assert not listed(wrong)
