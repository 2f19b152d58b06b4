"""The package's rooms: nothing is imported in a circle, nothing upwards, typing-only imports included."""

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import epibar

PACKAGE = Path(epibar.__file__).parent

ROOMS = (
    *("errors", "_core", "arguments", "geometry", "files", "sources", "lens", "camera_export", "foreground"),
    *("recording", "clocks", "health", "from_video", "motion_barcodes", "calibration", "network"),
    *("outcome", "show", "evaluation", "plot", "report", "live", "pair_export", "export"),
    *("jobs", "synthetic", "cli", "__main__"),
)
"""In the order of the data: each may import from those before it."""

MOST_AT_THE_TOP = 12
MOST_LINES = 400


def module_name(path):
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def modules():
    """Path of each module by its name; the package itself is called ''."""
    return {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))} | {
        "_core": PACKAGE / "_core.pyi"
    }


def imported(name, path, known):
    """Yield the modules that a module imports from this package, wherever in it."""
    package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
    package = [part for part in package if part]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            assert not any(alias.name.split(".")[0] == "epibar" for alias in node.names), f"{name}: relative"
        if not isinstance(node, ast.ImportFrom):
            continue
        if not node.level:
            assert (node.module or "").split(".")[0] != "epibar", f"{name}: import relatively"
            continue
        base = package[: len(package) - node.level + 1]
        target = ".".join([*base, *([node.module] if node.module else [])])
        for alias in node.names:
            inner = f"{target}.{alias.name}" if target else alias.name
            yield inner if inner in known else target


def imports():
    known = modules()
    return {name: set(imported(name, path, known)) for name, path in known.items()}


def test_nothing_is_imported_in_a_circle():
    try:
        TopologicalSorter(imports()).prepare()
    except CycleError as error:
        raise AssertionError(f"a circle: {' -> '.join(error.args[1])}") from None


def test_nothing_is_imported_upwards():
    order = {room: place for place, room in enumerate(ROOMS)}
    wrong = []
    for name, targets in imports().items():
        room = name.split(".")[0]
        if not room:
            continue  # what users import stands above all
        assert room in order, f"{room}: which place has it in ROOMS?"
        wrong += [
            f"{name} imports {target or 'epibar'}"
            for target in targets
            if target.split(".")[0] != room and order.get(target.split(".")[0], len(order)) > order[room]
        ]
    assert wrong == []


def test_there_is_little_at_the_top():
    files = [
        path.name for path in PACKAGE.iterdir() if path.is_file() and not path.name.startswith("_core.abi")
    ]
    files = [name for name in files if not name.endswith((".so", ".pyd"))]
    assert len(files) <= MOST_AT_THE_TOP, files


def test_files_are_short():
    long = {
        name: lines
        for name, path in modules().items()
        if (lines := len(path.read_text().splitlines())) > MOST_LINES
    }
    assert long == {}


def test_types_of_arrays_are_named_in_one_place():
    """An array in a signature says what it holds, by a name of ``arguments.py``."""
    spelt = re.compile(r"\bNDArray\b|(?:: |-> |\[|\| )np\.ndarray\b(?!\))")
    found = [name for name, path in modules().items() if name != "_core" and spelt.search(path.read_text())]
    assert found == ["arguments"]


def test_a_name_of_a_class_means_one_thing():
    """What is called the same in two rooms is taken for the other; the compiled module has its twins."""
    found = {}
    for name, path in modules().items():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef) and name != "_core":
                found.setdefault(node.name, []).append(name)
    assert {name: homes for name, homes in found.items() if len(homes) > 1} == {}


def defined_names(path):
    """Yield the name of a file, and those of functions, classes, arguments, variables and fields in it."""
    yield path.stem
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr


def test_no_name_says_that_a_thing_is_told():
    """A name says what a thing is; that somebody tells it is true of any."""
    paths = [*PACKAGE.rglob("*.py"), *(Path(__file__).parents[1] / "benchmarks").rglob("*.py")]
    named = {path.name: [name for name in defined_names(path) if "told" in name.lower()] for path in paths}
    assert {path: names for path, names in named.items() if names} == {}


def test_no_function_is_hidden_by_a_module_of_its_name():
    """Importing a module puts it into its package under its name, in place of a function called the same."""
    named = {name for name in modules() if name and "." not in name}
    functions = set(epibar.__all__) - {"export", "live", "plot"}
    assert not named & functions


def test_every_room_is_told_of_in_the_architecture():
    page = (Path(__file__).parents[1] / "docs" / "architecture.md").read_text()
    told = {
        word.removeprefix("python/epibar/").rstrip("/")
        for line in page.splitlines()
        if line.startswith("| `python/epibar/")
        for word in line.split("|")[1].replace("`", " ").replace(",", " ").split()
    }
    rooms = {path.name for path in PACKAGE.iterdir() if path.is_dir() and (path / "__init__.py").exists()}
    rooms |= {path.name for path in PACKAGE.glob("*.py") if not path.name.startswith("__")} | {"_core.pyi"}
    assert told == rooms
