"""calibration.json is what its JSON Schema says: every field that is written is described, and documented."""

import contextlib
import copy
import io
import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from jobs_input import FAST, write_masks

import epibar
from epibar import synthetic
from epibar.cli import main
from epibar.files.calibration_json import FORMAT, SCHEMA, schema

PAGE = Path(__file__).parents[1] / "docs" / "calibration_json.md"


def strict(described):
    """The schema with no room for fields that it does not describe."""
    found = copy.deepcopy(described)

    def close(part):
        if isinstance(part, dict):
            if "properties" in part:
                part.setdefault("additionalProperties", False)
            for inner in part.values():
                close(inner)
        elif isinstance(part, list):
            for inner in part:
                close(inner)

    close(found)
    return found


def refused(content):
    return list(jsonschema.Draft202012Validator(strict(schema())).iter_errors(content))


@pytest.fixture(scope="module")
def with_errors(tmp_path_factory):
    """A run of masks with a camera that cannot be read, and pairs that are refused: no error is so small."""
    folder = tmp_path_factory.mktemp("with_errors")
    masks = write_masks(folder)
    epibar.calibrate_all([*masks[:3], folder / "none.npz"], folder / "out", max_expected_error=1e-6, **FAST)
    return json.loads((folder / "out" / "calibration.json").read_text())


@pytest.fixture(scope="module")
def with_poses(tmp_path_factory):
    """A run with intrinsics, whose accepted pairs have poses, a floor and rivals."""
    folder = tmp_path_factory.mktemp("with_poses")
    scene = synthetic.people(seed=5, cameras=2, walkers=5, frames=300, size=(320, 240), asymmetric=True)
    tables, paths = [], []
    for index, camera in enumerate(scene.cameras):
        paths.append(folder / f"cam{index + 1}.npz")
        np.savez_compressed(paths[-1], masks=scene.masks(index), fps=25.0)
        tables.append(
            f'[cam_{index}]\nname = "cam{index + 1}"\nsize = {list(camera.size)}\n'
            f"matrix = {camera.K.tolist()}\ndistortions = []\n"
        )
    (folder / "cameras.toml").write_text("\n".join(tables))
    epibar.calibrate_all(
        paths, folder / "out", masks=True, lines=3000, intrinsics=folder / "cameras.toml", report=False
    )
    return json.loads((folder / "out" / "calibration.json").read_text())


def test_the_schema_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(schema())
    assert schema()["$id"] == SCHEMA
    assert schema()["properties"]["format"] == {**schema()["properties"]["format"], "const": FORMAT}


def test_what_is_written_is_described(with_errors, with_poses):
    assert with_errors["$schema"] == SCHEMA
    assert refused(with_errors) == []
    assert refused(with_poses) == []
    # The two together have something of everything.
    assert with_errors["errors"]
    pairs = with_errors["pairs"] + with_poses["pairs"]
    assert {pair["accepted"] for pair in pairs} == {True, False}
    assert {pair["kind"] for pair in pairs} <= set(
        schema()["$defs"]["pair"]["properties"]["kind"]["examples"]
    )
    assert any(pair["pose"] and "R" in pair["pose"] for pair in pairs)
    assert any(pair["evidence"] for pair in pairs)


def test_what_readers_rely_on_is_required(with_poses):
    """The fields that other programs call; taking one away breaks them."""
    promised = {"a", "b", "accepted", "kind", "reason", "F", "expected_error", "time_offset", "counts"}
    assert promised <= set(schema()["$defs"]["pair"]["required"])
    for field in promised:
        damaged = copy.deepcopy(with_poses)
        del damaged["pairs"][0][field]
        assert refused(damaged), field


@pytest.mark.parametrize(
    "change",
    [
        {"format": 2},
        {"cameras": None},
        {"pairs": [{}]},
        {"errors": [{"message": "no camera, no pair"}]},
        {"unheard_of": 1},
    ],
)
def test_what_is_something_else_is_refused(with_errors, change):
    assert refused({**with_errors, **change})


@pytest.mark.parametrize(
    ("field", "value"),
    [("F", [[1, 2], [3, 4]]), ("accepted", "yes"), ("expected_error", -1), ("pose", {}), ("a", "")],
)
def test_a_wrong_pair_is_refused(with_poses, field, value):
    wrong = copy.deepcopy(with_poses)
    wrong["pairs"][0][field] = value
    assert refused(wrong)


def test_later_fields_are_allowed(with_errors):
    """Format 1 may grow."""
    jsonschema.validate({**with_errors, "weather": {}}, schema())


def test_every_field_is_documented():
    described = {
        name for part in [schema(), *schema()["$defs"].values()] for name in part.get("properties", {})
    }
    told = set(re.findall(r"\| `(?:\w+\.)?([$\w]+)` \|", PAGE.read_text()))
    assert described <= told, described - told


def test_rows_of_the_page_are_those_of_the_schema():
    for line in PAGE.read_text().splitlines():
        row = re.match(r"\| `([$\w.]+)` \|", line)
        if row:
            names = row[1].split(".")
            part = schema() if len(names) == 1 else schema()["$defs"][names[0]]
            assert names[-1] in part["properties"], line


def test_what_a_seed_is_of_is_said_alike_everywhere():
    """Whether motion is too flat is asked by the same draws for every seed: no refusal hangs on one."""
    said = [part["properties"]["seed"]["description"] for part in (schema(), schema()["$defs"]["pair"])]
    said += [line for line in PAGE.read_text().splitlines() if re.match(r"\| `(pair\.)?seed` ", line)]
    for function in (epibar.calibrate, epibar.calibrate_network, epibar.Network.extended):
        said.append(function.__doc__.partition("seed : int")[2].partition(" : ")[0])
    helps = io.StringIO()
    with contextlib.redirect_stdout(helps):
        main(["calibrate", "--help"])
    said.append(helps.getvalue().partition("--seed N ")[2].partition(" --")[0])
    assert len(said) == 8
    for text in said:
        words = " ".join(text.split())
        assert "of the search" in words.lower(), words
        assert "how flat motion is judged does not" in words, words
