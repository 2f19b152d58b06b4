"""What the command line takes: options of all commands, short ones, completion, exit codes."""

import argparse
import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from jobs_input import WORDS, write_masks

import epibar
from epibar import synthetic
from epibar.calibration import MAX_EXPECTED_ERROR, SEARCH_SECONDS
from epibar.cli import main
from epibar.cli.exit_codes import DONE, INTERRUPTED, MOVED, PARTLY, UNUSABLE, exit_code
from epibar.cli.length_options import lengths
from epibar.cli.parser import COMMANDS, build_parser
from epibar.evaluation import image_correspondences
from epibar.recording import DEFAULT_LINES


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return [str(path) for path in write_masks(tmp_path_factory.mktemp("masks"))]


# --- what all commands have in common ---


def test_defaults_are_those_of_the_package():
    # Written out there, as help is shown without loading the compiled module.
    given = build_parser().parse_args(["calibrate", "c1", "c2", "-o", "D"])
    assert (given.search_seconds, given.max_expected_error) == (SEARCH_SECONDS, MAX_EXPECTED_ERROR)
    assert given.lines == DEFAULT_LINES
    assert build_parser().parse_args(["check", "D", "c1"]).search_seconds == SEARCH_SECONDS


@pytest.mark.parametrize("command", [module.NAME for module in COMMANDS])
def test_every_command_says_when_it_fails(command, capsys):
    assert main([command, "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "Exit codes: 0 done" in text
    told = {int(code) for code in re.findall(r"(?:^|; )(\d+) ", text.partition("Exit codes: ")[2])}
    may_end_with = {"calibrate": {PARTLY}, "demo": {PARTLY}, "inspect": {PARTLY}, "check": {PARTLY, MOVED}}
    assert told == {DONE, UNUSABLE, INTERRUPTED} | may_end_with.get(command, set())


@pytest.mark.parametrize("command", [module.NAME for module in COMMANDS])
def test_every_option_is_explained(command):
    (commands,) = (action for action in build_parser()._actions if action.dest == "command")
    for action in commands.choices[command]._actions:
        assert action.help or action.dest == "shell", f"{command} {action.dest}"


def test_every_command_is_quiet_or_verbose_when_asked():
    taken = {name: set() for name in (module.NAME for module in COMMANDS)}
    for command, action in arguments():
        if command is not None:
            taken[command] |= set(action.option_strings)
    for command, options in taken.items():
        assert {"-q", "--quiet", "-v", "--verbose"} <= options, command


def test_commands_that_only_print_are_quiet_or_verbose_too(capsys):
    """What other programs read is printed however quiet."""
    printed = {}
    for words in ("formats", "formats -v", "formats -q", "formats -q --json", "completion bash -q"):
        assert main(words.split()) == 0
        printed[words] = capsys.readouterr()
    assert printed["formats -q"] == ("", "")
    assert "aniposelib" in printed["formats"].out
    assert printed["formats -v"].out == printed["formats"].out
    assert f"epibar {epibar.__version__}" in printed["formats -v"].err
    assert json.loads(printed["formats -q --json"].out)
    assert "calibrate" in printed["completion bash -q"].out
    assert main(["completion", "bash", "-v"]) == 0
    assert f"epibar {epibar.__version__}" in capsys.readouterr().err


def test_short_options(masks, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["calibrate", *masks[:2], "-o", str(out), *WORDS, "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert (out / "calibration.json").exists()
    assert main(["calibrate", *masks[:2], "-o", str(out), *WORDS, "-v"]) == 0
    printed = capsys.readouterr()
    assert f"epibar {epibar.__version__}" in printed.err
    assert "  counts: " in printed.err
    assert "cam1 - cam2: " in printed.out
    saved = tmp_path / "cam1.npz"
    assert main(["record", masks[0], "--masks", "-o", str(saved), "--lines", "100", "-q"]) == 0
    assert main(["export", str(out), "--format", "csv", "--all", "-o", str(tmp_path / "points.csv")]) == 0
    assert (tmp_path / "points.csv").exists()


def test_the_largest_error_that_is_accepted_can_be_given(masks, tmp_path):
    """A pair is refused where less is asked for than it states, and is not taken from the run before."""
    words = ["calibrate", *masks[:2], "-o", str(tmp_path), *WORDS, "-q"]
    assert main(words) == 0
    (pair,) = json.loads((tmp_path / "calibration.json").read_text())["pairs"]
    assert pair["expected_error"] > 1e-6
    assert main([*words, "--max-expected-error", "1e-6"]) == 0
    (stricter,) = json.loads((tmp_path / "calibration.json").read_text())["pairs"]
    assert not stricter["accepted"]
    assert stricter["kind"] != "accepted"
    for value in ("0", "-1", "nan", "much"):
        assert main([*words, "--max-expected-error", value]) == 2


# --- exit codes ---


def test_exit_codes():
    assert exit_code(done=3, failed=0) == DONE
    assert exit_code(done=0, failed=0) == DONE
    assert exit_code(done=7, failed=1) == PARTLY
    assert exit_code(done=0, failed=2) == UNUSABLE


def test_nothing_done_and_one_of_many_failed(masks, tmp_path):
    words = ["-o", str(tmp_path / "out"), *WORDS, "-q"]
    assert main(["calibrate", *masks[:2], "none.npz", *words]) == 3
    assert main(["calibrate", masks[0], "none.npz", *words]) == 2
    assert main(["inspect", masks[0], "none.npz", "--masks", "-q", "--lines", "50"]) == 3
    assert main(["inspect", "none.npz", "--masks", "-q"]) == 2


# --- evaluate ---


def test_evaluate_for_programs(masks, tmp_path, capsys):
    assert main(["calibrate", *masks[:2], "-o", str(tmp_path), *WORDS, "-q"]) == 0
    known = tmp_path / "cameras.toml"
    tables = []
    scene = synthetic.cubes(3, cameras=4, objects=12, frames=200, size=(160, 120), size_m=(0.25, 0.45))
    for index, camera in enumerate(scene.cameras):
        rotation = cv2.Rodrigues(camera.R)[0].ravel().tolist()
        tables.append(
            f'[cam_{index}]\nname = "cam{index + 1}"\nsize = {list(camera.size)}\n'
            f"matrix = {camera.K.tolist()}\ndistortions = []\n"
            f"rotation = {rotation}\ntranslation = {camera.t.tolist()}\n"
        )
    known.write_text("\n".join(tables))
    capsys.readouterr()
    assert main(["evaluate", str(tmp_path), "--cameras", str(known), "--json"]) == 0
    (pair,) = json.loads(capsys.readouterr().out)["pairs"]
    assert pair["b"] == "cam2"
    # Over the image, where the definition can be applied to what is in the files.
    F = np.array(json.loads((tmp_path / "calibration.json").read_text())["pairs"][0]["F"])
    sizes = scene.cameras[0].size, scene.cameras[1].size
    a, b = image_correspondences(scene.fundamental(0, 1), *sizes)
    error = epibar.symmetric_epipolar_distance(F, a, b).mean()
    assert pair["image_error"] == pytest.approx(error)
    assert main(["evaluate", str(tmp_path), "--cameras", str(known)]) == 0
    assert f"{pair['image_error']:.2f} px" in capsys.readouterr().out


# --- completion ---


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completion_scripts(shell, capsys):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert "calibrate" in script
    assert "max-expected-error" in script


@pytest.fixture
def completed(tmp_path, monkeypatch, capsys):
    """What bash completes the last of some words to, in a folder with a file and a folder."""
    if shutil.which("bash") is None:
        pytest.skip("no bash")
    assert main(["completion", "bash"]) == 0
    script = tmp_path / "completion.bash"
    script.write_text(capsys.readouterr().out)
    (tmp_path / "here" / "a_folder").mkdir(parents=True)
    (tmp_path / "here" / "a_file.mp4").touch()
    monkeypatch.chdir(tmp_path / "here")

    def complete(*words):
        line = " ".join(["epibar", *words])
        typed = " ".join(f"'{word}'" for word in ("epibar", *words))
        code = (
            f"source {script}; COMP_WORDS=({typed}); COMP_CWORD={len(words)}; COMP_LINE='{line}'; "
            f"COMP_POINT={len(line)}; $(complete -p epibar | sed 's/.*-F //; s/ .*//') epibar; "
            'printf "%s\\n" "${COMPREPLY[@]}"'
        )
        return subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True).stdout.split()

    return complete


def test_bash_completes_options_and_choices(completed):
    assert "calibrate" in completed("cal")
    assert completed("calibrate", "--max") == ["--max-expected-error"]
    assert completed("calibrate", "--foreground", "k") == ["knn"]


FOLDERS = {"calibrate --out", "demo --out", "check folder", "export folder", "scale folder", "sync folder"}
FILES = {"VIDEO", "PATH", "FILE.toml", "FILE.npz", "MASK.png", "calibration.json"}
NEITHER = {None, "N", "N|auto", "N|auto|search", "S", "PX", "M", "FIRST:LAST", "ADDRESS"}
NEITHER |= {("A", "M"), ("A", "B", "M")}


def test_bash_completes_files_only_where_an_option_takes_one(completed):
    """Every argument and option of every command, those that a newer epibar has included."""
    for command, action in arguments():
        if command is None or action.nargs == 0:
            continue
        name = next((one for one in action.option_strings if one.startswith("--")), action.dest)
        words = [name, "a_"] if action.option_strings else ["a_"]
        before = ["a_folder"] if command == "check" and name == "videos" else []
        if f"{command} {name}" in FOLDERS:
            expected = {"a_folder"}
        elif action.metavar in FILES:
            expected = {"a_folder", "a_file.mp4"}
        else:
            assert action.metavar in NEITHER or action.choices, f"{command} {name}: a path?"
            expected = set()
        assert set(completed(command, *before, *words)) == expected, f"{command} {name}"


def test_completion_without_its_library(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 2
    assert "epibar[completion]" in capsys.readouterr().err


# --- what advice names ---

PACKAGE = Path(epibar.__file__).parent


def arguments():
    """Commands, None for what is before them, with each of their arguments and options."""
    parser = build_parser()
    commands = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    yield from ((None, action) for action in parser._actions)
    for name, command in commands.choices.items():
        yield from ((name, action) for action in command._actions)


def known_options():
    """The options of all commands."""
    return {option for _, action in arguments() for option in action.option_strings}


def named_options():
    """Yield where which option is named: in any string of the package."""
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                for option in re.findall(r"(?<![\w-])--[a-z][a-z-]*", node.value):
                    yield path.relative_to(PACKAGE).as_posix(), option


def test_every_option_that_is_advised_exists():
    """What a warning, an error, or the report's advice tells to do can be done."""
    known = known_options()
    named = list(named_options())
    assert [one for one in named if one[1] not in known] == []
    # It looks where advice stands.
    advised = {option for path, option in named if path == "report/prose.py"}
    assert advised >= {"--background", "--time-offset", "--ignore", "--intrinsics", "--max-expected-error"}
    assert ("health/camera_findings.py", "--frames") in named


@pytest.mark.parametrize("name", ["-x", "--left", "-1a"])
def test_names_of_cameras_may_begin_with_a_dash(name):
    parser = build_parser()
    words = ["scale", "DIR", "--distance", name, "cam2", "4.2", "--distance", "cam2", name, "3", "-q"]
    args = parser.parse_args([*words, "--camera-height", name, "2"])
    found = lengths(args)
    assert found["distance"] == [(name, "cam2", 4.2), ("cam2", name, 3.0)]
    assert found["camera_height"] == [(name, 2.0)]
    assert args.quiet


def test_an_option_is_no_name_of_a_camera(capsys):
    with pytest.raises(SystemExit):
        build_parser().parse_args(["scale", "DIR", "--distance", "cam1", "-q", "4.2"])
    assert "--distance" in capsys.readouterr().err
