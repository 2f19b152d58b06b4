"""What the README and the documentation tell a reader to type does what they say.

Every ``epibar`` command of a ``sh``, ``bash`` or ``console`` block is run, in the order of its document, in a
folder that holds small videos under the names the documents use. So that this takes seconds, they are 160×120
and of flying cubes, `quickened` adds ``--lines`` and ``--method lines`` where a command leaves them open, the
demo is a small one, and Python blocks calibrate by ``method="lines"`` too. That a command is accepted and its
files appear is tested here; how good its result is, elsewhere.

A comment before a block keeps it from being run: ``<!-- parsed only: why -->`` for what takes long or needs
more than this machine, ``<!-- not run: why -->`` for Python that cannot run as it stands. A command with the
address of another machine is parsed only as well.
"""

import functools
import re
import shlex
import subprocess
import sys
import tomllib
from glob import glob
from pathlib import Path

import cv2
import numpy as np
import pytest

import epibar
from epibar import synthetic
from epibar.cli import demo, main
from epibar.cli.parser import COMMANDS, build_parser
from epibar.lens.cameras_toml import write_cameras
from epibar.lens.intrinsics import Intrinsics

ROOT = Path(__file__).parents[1]
DOCUMENTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
PACKAGE = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]

BLOCK = re.compile(
    r"(?:<!-- (?P<mark>[^>]*?): [^>]*-->\n)?^```(?P<language>\w+)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
SIZE, FRAMES = (160, 120), 300
MARKS = {None, "parsed only", "not run"}
OF_THE_SHELL = {"cd", "git", "source"}
"""Name nothing of ours that could be looked up."""


def blocks(document, *languages):
    """Yield the mark, the first line's number and the text of each block."""
    text = document.read_text()
    for found in BLOCK.finditer(text):
        if found["language"] in languages:
            assert found["mark"] in MARKS, f"{document.name}: {found['mark']}"
            yield found["mark"], text.count("\n", 0, found.start("text")) + 1, found["text"]


def commands(document):
    """Yield the mark, the line number and the words of every command."""
    for mark, number, text in blocks(document, "sh", "bash", "console"):
        typed = text.splitlines()
        if any(line.startswith("$ ") for line in typed):  # a session, with what it prints
            typed = [line.removeprefix("$ ") if line.startswith("$ ") else "" for line in typed]
        for offset, line in enumerate("\n".join(typed).replace("\\\n", "  ").splitlines()):
            words = shlex.split(line, comments=True)
            if words:
                yield mark, number + offset, words


def quickened(words):
    """Add what makes a command fast, where it says nothing else."""
    if words[0] in {"calibrate", "record", "inspect"} and "--lines" not in words:
        words = [*words, "--lines", "3000"]
    if words[0] == "calibrate" and "--method" not in words:
        words = [*words, "--method", "lines"]
    return words


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A folder with three cameras, and all that may be said about them, and ``calibrated``."""
    folder = tmp_path_factory.mktemp("reader")
    scene = synthetic.cubes(seed=0, cameras=3, objects=8, frames=FRAMES, size=SIZE)
    known, empty = [], synthetic.cubes(seed=0, cameras=3, objects=0, frames=1, size=SIZE)
    for index, camera in enumerate(scene.cameras):
        name = f"cam{index + 1}"
        assert synthetic.render_video(scene, index, folder / f"{name}.mp4", noise=1).suffix == ".mp4"
        synthetic.render_video(empty, index, folder / f"empty{index + 1}.mp4", noise=1)
        np.savez_compressed(folder / f"{name}_masks.npz", masks=scene.masks(index), fps=scene.fps)
        ignored = np.zeros(SIZE[::-1], np.uint8)
        ignored[:8, :16] = 255
        cv2.imwrite(str(folder / f"mask{index + 1}.png"), ignored)
        rotation = cv2.Rodrigues(camera.R)[0].ravel()
        known.append(Intrinsics(name, camera.size, camera.K, rotation=rotation, translation=camera.t))
    write_cameras(folder / "cameras.toml", known)
    videos = [str(folder / f"cam{number}.mp4") for number in (1, 2, 3)]
    words = ["calibrate", *videos, "--out", str(folder / "calibrated"), "--quiet", "--no-report"]
    assert main(quickened(words)) == 0
    return folder


@pytest.fixture(scope="module")
def ran():
    """Commands that were run already, for some other document."""
    return set()


def is_epibar(words):
    return Path(words[0]).name == "epibar"


def arguments(words):
    """Return what the shell would give to the program, wildcards expanded in the present folder."""
    found = []
    for word in words[1:]:
        if word == ">":
            break
        found += sorted(glob(word)) if "*" in word else [word]
    return found


NAMES = [path.relative_to(ROOT).as_posix() for path in DOCUMENTS]


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_epibar_commands(document, prepared, ran, monkeypatch, capsys):
    monkeypatch.chdir(prepared)
    monkeypatch.setattr(demo, "CAMERAS", 2)
    monkeypatch.setattr(demo, "SECONDS", 1.2)
    monkeypatch.setattr(demo, "SIZE", SIZE)
    for mark, number, words in commands(document):
        if not is_epibar(words):
            continue
        place = f"{document.name}:{number}: {shlex.join(words)}"
        given = arguments(words)
        if given == ["--version"]:
            assert main(given) == 0, place
            continue
        args = parsed(given, place)
        if mark or re.search(r"(tcp|tls)://", " ".join(given)):
            continue
        if shlex.join(words) not in ran:
            code = main(quickened(given))
            assert code == 0, f"{place}\n{capsys.readouterr().err}"
            ran.add(shlex.join(words))
        if hasattr(args, "out"):
            assert Path(args.out).exists(), place


def parsed(given, place):
    try:
        return build_parser().parse_args(given)
    except SystemExit:
        pytest.fail(f"{place}: not understood")


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_other_commands(document):
    for mark, number, words in commands(document):
        if mark is None and not is_epibar(words):
            place = f"{document.name}:{number}: {shlex.join(words)}"
            check_other(words, place)


def check_other(words, place):
    """Look up what a command names: the target, the example, the extra, the options."""
    program, given = Path(words[0]).name, words[1:]
    if program == "make":
        targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
        assert set(given) <= set(targets), place
    elif program == "pip":
        assert given[0] == "install", place
        extras = re.findall(r"\[([\w,-]+)\]", given[-1])
        assert set(",".join(extras).split(",")) <= {"", *PACKAGE["optional-dependencies"]}, place
    elif program in {"pipx", "uv"}:
        assert given[-2:] == ["install", "epibar"], place
    elif program == "cargo":
        # That the examples compile, and the documentation builds, cargo tests.
        assert given[0] in {"add", "bench", "doc", "run", "test"}, place
        if "--example" in given:
            example = given[given.index("--example") + 1]
            assert (ROOT / "rust/epibar/examples" / f"{example}.rs").exists(), place
    elif program in {"python", "dask"}:
        assert_options_exist(program, given, place)
    elif program not in OF_THE_SHELL:
        pytest.fail(f"{place}: no test knows this program; mark the block, or teach it")


def assert_options_exist(program, given, place):
    options = {word.partition("=")[0] for word in given if word.startswith("--")}
    if program == "python":
        assert (ROOT / given[0]).exists(), place
    if not options:
        return
    start = [sys.executable, given[0]] if program == "python" else [sys.executable, "-m", "dask", given[0]]
    shown = subprocess.run([*start, "--help"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert shown.returncode == 0, f"{place}\n{shown.stderr}"
    missing = {option for option in options if option not in shown.stdout}
    assert not missing, f"{place}: no option {', '.join(missing)}"


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_python_blocks(document, prepared, monkeypatch, capsys):
    """One after the other, as a reader would; ``masks`` is what the README takes as given."""
    monkeypatch.chdir(prepared)
    monkeypatch.setattr(epibar, "calibrate", functools.partial(epibar.calibrate, method="lines"))
    with np.load("cam1_masks.npz") as archive:
        names = {"masks": archive["masks"]}
    for mark, number, text in blocks(document, "python"):
        code = compile("\n" * (number - 1) + text, str(document), "exec")
        if mark is None:
            exec(code, names)


def test_every_command_is_shown():
    shown = {words[1] for document in DOCUMENTS for _, _, words in commands(document) if is_epibar(words)}
    assert {module.NAME for module in COMMANDS} <= shown


def test_every_public_name_is_in_the_reference():
    shown = set(re.findall(r":: epibar\.(\w+)", (ROOT / "docs" / "api.md").read_text()))
    assert set(epibar.__all__) - {"__version__"} <= shown


def test_the_readme_works_outside_the_repository():
    """The index shows it alone: pictures and links are whole addresses, of files that are here."""
    text = (ROOT / "README.md").read_text()
    targets = re.findall(r"\]\(([^)]+)\)", text)
    assert len(targets) > 5
    for target in targets:
        address = re.fullmatch(
            r"https://(raw\.githubusercontent|github)\.com/epibar/epibar/(blob/)?main/(.+)", target
        )
        assert address, f"{target} is no whole address"
        assert (ROOT / address[3]).exists(), target
        picture = target.endswith(".png")
        assert picture == (address[1] == "raw.githubusercontent"), target


def test_a_wrong_option_is_noticed(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("```sh\nepibar calibrate a.mp4 b.mp4 --outt x   # a comment\n```\n")
    ((mark, number, words),) = commands(page)
    assert (mark, number) == (None, 2)
    with pytest.raises(pytest.fail.Exception, match="page"):
        parsed(words[1:], "page")


def test_masks_to_f():
    script = ROOT / "examples" / "masks_to_f.py"
    shown = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
    assert "accepted: True" in shown
    assert float(re.search(r"([\d.]+) px", shown)[1]) < 1


def test_the_notebook(tmp_path):
    import nbformat
    from nbclient import NotebookClient

    source = ROOT / "examples" / "first_result.ipynb"
    notebook = nbformat.read(source, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in cells), (
        "clear its outputs before a commit"
    )
    NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": tmp_path}}
    ).execute()
    figures = [out for cell in cells for out in cell.outputs if "image/png" in out.get("data", {})]
    assert len(figures) == 5
