"""Which words of a command line are videos, and which are values of options that have one for each camera."""

import re

import pytest

from epibar.cli import main
from epibar.cli.parser import build_parser


@pytest.fixture(autouse=True)
def empty_folder(tmp_path, monkeypatch):
    """What is run though it should be refused writes nothing into the repository."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    "words",
    [
        "c1 c2 --background b1 b2 --out D",
        "c1 c2 --out D --background b1 b2",
        "--background b1 b2 --out D c1 c2",
        "--background b1 --background b2 c1 c2 --out D",
        "--background b1 c1 --background b2 c2 --out D",
        "--background=b1 --background=b2 c1 c2 --out D",
        "--background b1 b2 -o D -- c1 c2",
        "--out D --background b1 b2 -- c1 c2",
        "c1 -o D c2 --background b1 b2",
        "c1 --background b1 b2 -o D c2",
    ],
)
def test_videos_are_left_alone(words):
    given = build_parser().parse_args(["calibrate", *words.split()])
    assert (given.videos, given.background, given.ignore, given.out) == (
        ["c1", "c2"],
        ["b1", "b2"],
        None,
        "D",
    )


@pytest.mark.parametrize(
    ("words", "took"),
    [
        ("--background b1 b2 c1 c2", "--background took b1, b2, c1, c2, and"),
        ("--background b1 c1 c2 c3", "--background took b1, c1, c2, c3, and"),
        ("--background b1 b2 c1 c2 c3 c4", "--background took b1, b2, c1, c2, c3, c4, and"),
        ("--background b1 b2 c1", "--background took b1, b2, c1, and"),
        ("--ignore m1 c1 c2 c3", "--ignore took m1, c1, c2, c3, and"),
        ("--background b1 --background b2 c1 c2 c3 c4", "--background took b1, b2, c1, c2, c3, c4, and"),
        ("--ignore m1 m2 c1 c2 --background b1", "--ignore took m1, m2, c1, c2, and"),
        (
            "--background b1 b2 b3 --ignore m1 m2 m3 c1 c2 c3",
            "--background took b1, b2, b3; --ignore took m1, m2, m3, c1, c2, c3, and",
        ),
        (
            "--background b1 b2 b3 c1 c2 c3 --ignore m1 m2 m3",
            "--background took b1, b2, b3, c1, c2, c3; --ignore took m1, m2, m3, and",
        ),
        (
            "--ignore m1 --ignore m2 m3 --background b1 b2 b3 c1 c2 c3",
            "--background took b1, b2, b3, c1, c2, c3; --ignore took m1, m2, m3, and",
        ),
        (
            "--ignore m1 m2 m3 --background b1 b2 c1 c2 c3 c4",
            "--background took b1, b2, c1, c2, c3, c4; --ignore took m1, m2, m3, and",
        ),
    ],
)
@pytest.mark.parametrize("others", ["-o D", "-q -o D"])
def test_which_values_are_videos_is_never_guessed(words, took, others, capsys):
    """No camera becomes the empty scene of another one."""
    for written in (f"{words} {others}", f"{others} {words}"):
        assert main(["calibrate", *written.split()]) == 2
        printed = capsys.readouterr().err
        assert f"argument VIDEO: none is left: {took} which of them are videos cannot be told" in printed
        assert re.search(
            r"first, as in 'epibar calibrate a\.mp4 b\.mp4 (--\w+) \.\.\.', or end the values of \1 with --$",
            printed,
        )


def test_a_folder_that_an_option_took_is_missed_with_what_to_do(capsys):
    assert main(["check", "--background", "e1", "e2", "D", "a", "b"]) == 2
    printed = capsys.readouterr().err
    assert "arguments are required: DIR" in printed
    assert "--background takes all that stands behind it: put it last, or end its values with --" in printed
    assert main(["check"]) == 2
    assert "stands behind it" not in capsys.readouterr().err


@pytest.mark.parametrize(("command", "as_in"), [("inspect", "inspect"), ("check D", "check DIR")])
def test_the_way_out_is_that_of_the_command(command, as_in, capsys):
    assert main([*command.split(), "--background", "b1", "c1", "c2", "c3"]) == 2
    assert f"as in 'epibar {as_in} a.mp4 b.mp4 --background ...'" in capsys.readouterr().err


def test_one_value_and_one_video_can_be_read_in_one_way():
    given = build_parser().parse_args(["inspect", "--background", "b1", "c1"])
    assert (given.videos, given.background) == (["c1"], ["b1"])


@pytest.mark.parametrize(
    "words",
    [
        "--background b1 b2 b3 --ignore m1 m2 m3 -- c1 c2 c3",
        "--background b1 b2 b3 --ignore m1 m2 m3 -q c1 c2 c3",
        "--ignore m1 --ignore m2 m3 --background b1 b2 b3 -q c1 c2 c3",
        "c1 c2 c3 --background b1 b2 b3 --ignore m1 m2 m3",
        "c1 c2 c3 --ignore m1 --ignore m2 m3 --background b1 b2 b3",
        "--background b1 --background b2 --background b3 --ignore m1 --ignore m2 --ignore m3 c1 c2 c3",
    ],
)
def test_videos_are_left_alone_by_two_options(words):
    given = build_parser().parse_args(["inspect", *words.split()])
    assert given.videos == ["c1", "c2", "c3"]
    assert given.background == ["b1", "b2", "b3"]
    assert given.ignore == ["m1", "m2", "m3"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("-o D", "VIDEO"),
        ("--background b1 b2 c1 -o D", "VIDEO"),  # of three it cannot be said which are videos
        ("c1 c2 --background b1 -o D", "--background: 1 given for 2 cameras"),
        ("c1 --background b1 b2 b3 -o D", "at least two cameras"),
        ("c1 c2 -o D --outt D", "--outt"),
    ],
)
def test_what_does_not_fit_is_refused(words, told, capsys):
    assert main(["calibrate", *words.split()]) == 2
    assert told in capsys.readouterr().err
