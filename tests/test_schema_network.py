"""network.json is what its JSON Schema says, alone and as a part of calibration.json."""

import copy
import json

import jsonschema
import numpy as np
import pytest
from network_input import made_up
from test_schema import strict

from epibar.files import calibration_json, network_json
from epibar.files.network_json import FORMAT, SCHEMA, schema


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """A network in metres, one of whose cameras has no place."""
    path = tmp_path_factory.mktemp("saved") / "network.json"
    made_up().scaled(distance=("cam1", "cam2", 4.2)).save(path)
    return json.loads(path.read_text())


def refused(content):
    return list(jsonschema.Draft202012Validator(strict(schema())).iter_errors(content))


def test_the_schema_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(schema())
    assert schema()["$id"] == SCHEMA != calibration_json.SCHEMA
    assert schema()["properties"]["epibar_network"]["const"] == FORMAT


def test_what_is_written_is_described(saved):
    assert saved["$schema"] == SCHEMA
    assert saved["scale"] is not None
    assert {camera["accepted"] for camera in saved["cameras"]} == {True, False}
    assert refused(saved) == []


def test_it_is_the_part_of_calibration_json():
    """Whoever adds a field to one of the two adds it to the other."""
    parts = calibration_json.schema()["$defs"]
    alone, within = schema(), parts["network"]
    own = {"$schema", "epibar_key"}  # of the file
    assert set(alone["properties"]) == set(within["properties"]) | own
    for name in set(within["properties"]) - {"epibar_network"}:
        assert alone["properties"][name] == within["properties"][name], name
    assert alone["required"] == within["required"]
    assert alone["$defs"] == {name: parts[name] for name in alone["$defs"]}


@pytest.mark.parametrize(
    "change",
    [{"epibar_network": 2}, {"unit": "foot"}, {"cameras": [{}]}, {"ground": None}, {"unheard_of": 1}],
)
def test_what_is_something_else_is_refused(saved, change):
    assert refused({**saved, **change})


@pytest.mark.parametrize(
    ("field", "value"),
    [("rotation", np.eye(2).tolist()), ("width", 0), ("expected", {}), ("distortions", [0.0]), ("name", "")],
)
def test_a_wrong_camera_is_refused(saved, field, value):
    wrong = copy.deepcopy(saved)
    wrong["cameras"][0][field] = value
    assert refused(wrong)


def test_later_fields_are_allowed(saved):
    jsonschema.validate({**saved, "weather": {}}, network_json.schema())
