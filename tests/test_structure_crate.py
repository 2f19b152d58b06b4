"""The crate's rooms: nothing is imported in a circle, nothing upwards; every room has its row.

The binding has no circle either. By itself, with a folder of sources of any commit, it prints their circles.
"""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CRATE = ROOT / "rust" / "epibar" / "src"
BINDING = ROOT / "rust" / "epibar-py" / "src"

ROOMS = (
    *("error", "watch", "random", "bits_of_bytes", "image", "geometry", "recording", "foreground"),
    *("matching", "frontier", "refine", "hypotheses", "search", "clock", "verify"),
    *("options", "calibration", "calibrate", "examine", "files", "network"),
)
"""From tools to jobs: each may import from those before it. The root and `internals` stand above all."""

NETWORK_ROOMS = (
    *("thresholds", "model", "given", "observations", "solve", "evidence"),
    *("result", "case", "verdict"),
    *("join", "calibrate", "check", "add", "walkers"),
)
"""Those of the room `network`, in the same way; its own file re-exports, and stands above them."""

MOST_AT_THE_TOP = 12
MOST_IN_THE_NETWORK = 8
MOST_LINES = 400
FEW_FILES = 8

NO_NAMES = {"glance", "glanced", "shaken", "told"}
"""Words for which the field has better ones, or that say nothing. Prose may use them."""


def modules(sources):
    """Path of each module's file by its name."""
    found = {}
    for path in sorted(sources.rglob("*.rs")):
        parts = path.relative_to(sources).with_suffix("").parts
        found["::".join(parts[:-1] if parts[-1] == "mod" else parts)] = path
    return found


def code(path):
    """Read a file without its comments, its tests, and who may see what."""
    text = re.sub(r"//[^\n]*|\bpub\(in [\w:]+\)", "", path.read_text())
    return re.split(r"#\[cfg\(test\)\]\s*(?:pub(?:\(\w+\))? )?mod", text)[0]


def members(group):
    """Yield the paths in a group, those of groups in it included, from what stands after its brace."""
    outer, before, path = [], [], []
    for token in re.finditer(r"\w+|[{},]", group):
        if token[0] not in "{},":
            path.append(token[0])
            continue
        if token[0] == "{":
            outer.append(before)
            before = path
        elif len(path) > len(before):
            yield path
        if token[0] == "}":
            if not outer:
                return
            before = outer.pop()
        path = list(before)


def children(name, text):
    """Which modules a file declares; a path may begin with their names."""
    return re.findall(r"\bmod (\w+);", text) if name else []


def imported(name, text, known):
    """Yield the modules whose names a module uses, those that it re-exports included."""
    own = name.split("::")
    begins = "|".join(["crate", "super", "self", *children(name, text)])
    for found in re.finditer(rf"(?<![\w.:])({begins})\b((?:::\w+)*)(::\{{)?", text):
        start, names, group = found.groups()
        if not names and not group:
            continue  # the value `self`, or a variable that is called like a module
        base = {"crate": [], "super": own[:-1], "self": own}.get(start, [*own, start])
        names = names.split("::")[1:]
        while names[:1] == ["super"]:
            base, names = base[:-1], names[1:]
        for end in members(text[found.end() :]) if group else [[]]:
            target = [*base, *names, *end]
            while target and "::".join(target) not in known:
                target = target[:-1]
            if not target and start == "crate":
                yield "lib"  # through the root, which stands above all
            elif target and target != own:
                yield "::".join(target)


def imports(sources=CRATE):
    """Which modules each imports; the root and the door to internals re-export, and are above all."""
    known = modules(sources)
    return {
        name: set(imported(name, code(path), known))
        for name, path in known.items()
        if name not in {"lib", "internals"}
    }


def binding_imports():
    return imports(BINDING)


def rooms(inside="", sources=CRATE):
    """Which rooms each imports from: of the crate, or inside of one of its rooms."""
    found = {}
    for name, targets in imports(sources).items():
        if name.startswith(inside):
            room = found.setdefault(name.removeprefix(inside).split("::")[0], set())
            near = [target for target in targets if f"{target}::".startswith(inside)]
            room |= {target.removeprefix(inside).split("::")[0] for target in near}
    return {room: targets - {room} for room, targets in found.items()}


def network_rooms():
    return rooms("network::")


def reached(graph, start):
    """What is imported from somewhere, at whatever distance."""
    seen, ahead = set(), [start]
    while ahead:
        new = graph.get(ahead.pop(), set()) - seen
        seen |= new
        ahead += new
    return seen


def circles(graph):
    """Groups whose members all import one another, at whatever distance."""
    ways = {name: reached(graph, name) for name in graph}
    groups = {
        frozenset(other for other in ways if name in ways[other] and other in ways[name]) for name in ways
    }
    return sorted(sorted(group) for group in groups if group)


@pytest.mark.parametrize("graph", [imports, rooms, network_rooms, binding_imports])
def test_nothing_is_imported_in_a_circle(graph):
    assert circles(graph()) == []


def test_circles_are_found():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set(), "e": {"f"}, "f": {"e"}, "g": {"a"}}
    assert circles(graph) == [["b", "c"], ["e", "f"]]


def upwards(graph, listed=ROOMS):
    """What is imported from a room further down in a list, in words."""
    order = {room: place for place, room in enumerate(listed)}
    assert graph.keys() <= order.keys(), f"{graph.keys() - order.keys()}: which place have they in the list?"
    return [
        f"{name} imports {target}"
        for name, targets in graph.items()
        for target in sorted(targets)
        if order.get(target, len(order)) > order[name]
    ]


@pytest.mark.parametrize(("found", "listed"), [(rooms, ROOMS), (network_rooms, NETWORK_ROOMS)])
def test_nothing_is_imported_upwards(found, listed):
    assert set(listed) == found().keys()
    assert upwards(found(), listed) == []


def test_imports_upwards_are_found():
    assert upwards({"matching": {"recording", "search"}}) == ["matching imports search"]
    assert upwards({"search": {"internals"}}) == ["search imports internals"]
    assert upwards({"model": {"thresholds", "given"}}, NETWORK_ROOMS) == ["model imports given"]
    assert upwards({"model": {"network"}}, NETWORK_ROOMS) == ["model imports network"]
    found = network_rooms()
    assert {"result", "case", "evidence", "solve"} <= found["verdict"]
    assert {room for room, targets in found.items() if "join" in targets} == {"calibrate"}


@pytest.mark.parametrize(("whose", "listed"), [("the crate", ROOMS), ("the network", NETWORK_ROOMS)])
def test_the_architecture_tells_the_order(whose, listed):
    """The rooms that it names in its line on the order stand there as here."""
    page = (ROOT / "docs" / "architecture.md").read_text()
    told = re.search(rf"\*\*Rooms of {whose} import downwards only\*\*:(.*?)\. ", page, re.DOTALL)
    named = [name for name in re.findall(r"`(\w+)(?:\.rs)?`", told[1]) if name in listed]
    assert named == [room for room in listed if room in named]
    assert len(named) >= 12


def files_of(room):
    """The modules that a room declares."""
    return re.findall(r"^(?:pub )?mod (\w+);", (room / "mod.rs").read_text(), re.MULTILINE)


def rooms_with_guides():
    """Rooms in which nobody finds a file without a list, and all of the network."""
    every = [path.parent for path in sorted(CRATE.rglob("mod.rs"))]
    return [
        room
        for room in every
        if len(files_of(room)) > FEW_FILES or CRATE / "network" in [room, *room.parents]
    ]


def test_rooms_with_many_files_have_guides():
    assert {"verify", "geometry", "foreground", "network", "given"} <= {
        room.name for room in rooms_with_guides()
    }


@pytest.mark.parametrize("room", rooms_with_guides(), ids=lambda room: room.name)
def test_rooms_list_all_their_files(room):
    """The list in the comment that opens it and each room is true: every file once, and no other."""
    text = (room / "mod.rs").read_text()
    listed = re.findall(r"`(\w+)`", "".join(re.findall(r"^//! \* (.*?):", text, re.MULTILINE)))
    assert sorted(listed) == sorted(files_of(room))


def test_imports_are_found():
    """In groups, in groups of groups, through `super`, and where a path begins with a child's name."""
    known = {"a", "a::b", "a::c", "d", "d::e"}
    text = "use crate::d::{X, e::{Y, Z}};\nuse super::c::V;\nfn f(&self) { crate::a::g(self::h()) }"
    assert set(imported("a::b", text, known)) == {"d", "d::e", "a::c", "a"}
    assert list(imported("a::b", "use super::{c::{self, V}, c::W,};", known)) == ["a::c"] * 3
    for child in ("use b::X;", "pub use b::{X, Y};", "fn f() { b::g() }"):
        assert set(imported("a", "mod b;\n" + child, known)) == {"a::b"}
    for root in ("use crate::Verdict;", "use crate::{Verdict, d::X};", "fn f(x: crate::Verdict) {}"):
        assert "lib" in set(imported("a", root, known))
    assert set(imported("a", "mod b;\nuse crate::d::b::X;\nfn f(b: B) { b.g(b) }", known)) == {"d"}
    found = rooms()
    assert {"matching", "search", "verify", "clock"} <= found["calibrate"]
    assert {room for room, targets in found.items() if "calibrate" in targets} == {"network"}
    assert {"convert", "recording"} <= binding_imports()["lines"]


def types(text):
    """Find the names of types that code declares; a `type` inside of braces is a trait's, not its own."""
    return re.findall(
        r"\b(?:struct|enum|union|trait) (\w+)|^(?:pub(?:\(\w+\))? )?type (\w+)", text, re.MULTILINE
    )


def declared(sources):
    """In which files each type is declared."""
    found = {}
    for path in sorted(sources.rglob("*.rs")):
        for names in types(code(path)):
            found.setdefault("".join(names), []).append(path.relative_to(sources).as_posix())
    return found


def test_no_two_types_have_one_name():
    found = declared(CRATE)
    assert {name: files for name, files in found.items() if len(files) > 1} == {}
    assert {"Fundamental", "Recording", "Generator", "Watch"} <= found.keys()


def test_types_are_found():
    text = "pub struct A<T>(T);\nimpl Iterator for A {\n    type Item = u8;\n}\n"
    text += "pub(crate) type B = A;\nfn f() {\n    struct C;\n}"
    assert ["".join(names) for names in types(text)] == ["A", "B", "C"]


def words(name):
    """The words that a name is made of, small."""
    return {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}


def names(path):
    """Yield all names in a file, its own included; what is quoted is no name."""
    yield path.stem
    yield from re.findall(r"[A-Za-z_]\w*", re.sub(r'"(?:[^"\\]|\\.)*"', "", code(path).replace("'\"'", "")))


@pytest.mark.parametrize("sources", [CRATE, BINDING])
def test_names_are_of_words_that_say_something(sources):
    found = {name for path in sources.rglob("*.rs") for name in names(path)}
    assert {name for name in found if words(name) & NO_NAMES} == set()
    assert "recording" in found


def test_words_and_names_are_found(tmp_path):
    assert words("GLANCE_STEP") | words("ClockTold") | words("by_told2") == {
        *("glance", "step", "clock", "told", "by")
    }
    path = tmp_path / "told_by.rs"
    path.write_text('// is told\nlet is = ["was \\"told", "told"]; let told = \'"\';')
    assert list(names(path)) == ["told_by", "let", "is", "let", "told"]


def test_there_is_little_at_the_top():
    for folder, most in ((CRATE, MOST_AT_THE_TOP), (CRATE / "network", MOST_IN_THE_NETWORK)):
        files = [path.name for path in folder.iterdir() if path.is_file()]
        assert len(files) <= most, files


def test_files_are_short():
    lines = {path.name: path.read_text().count("\n") for path in CRATE.rglob("*.rs")}
    assert {name: count for name, count in lines.items() if count > MOST_LINES} == {}


def test_every_room_is_told_of_in_the_architecture():
    rows = [line.split("|")[1:3] for line in (ROOT / "docs" / "architecture.md").read_text().splitlines()]
    rows = ["".join(row) for row in rows if "`rust/epibar/src/" in "".join(row)]
    told = {
        name.removeprefix("rust/epibar/src/").rstrip("/") for name in re.findall(r"`([^`]+)`", "".join(rows))
    }
    assert {path.name for path in CRATE.iterdir()} - told == set()
    folders = {path.relative_to(CRATE).as_posix() for path in CRATE.rglob("*") if path.is_dir()}
    assert folders - told == set()


def test_where_something_is_is_answered_by_a_file():
    page = (ROOT / "docs" / "architecture.md").read_text()
    answers = re.findall(r"^\| [A-Z][^|]*\? \|([^|]*)\|$", page, re.MULTILINE)
    assert len(answers) > 10
    named = [name for answer in answers for name in re.findall(r"`([^`]+/[^`]*)`", answer)]
    assert [name for name in named if not (ROOT / name).is_file()] == []


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for what, graph in (("modules", imports(folder)), ("rooms", rooms(sources=folder))):
        sys.stdout.write(f"{len(graph)} {what}, in circles: {circles(graph)}\n")
