"""How progress is shown: one bar on a terminal, lines in a log, widgets in a notebook."""

import io
import logging
import re
import sys
import types

import pytest
from jobs_input import FAST, write_masks
from progress_input import Clock

import epibar
from epibar.cli import console as console_module
from epibar.cli.console import Console
from epibar.jobs import JobProgress, Row, Watch, showing
from epibar.jobs.pace import left_in_words
from epibar.jobs.watch import default_watch


@pytest.fixture(scope="module")
def masks(tmp_path_factory):
    return write_masks(tmp_path_factory.mktemp("masks"))


class Terminal(io.StringIO):
    """A stream that somebody watches."""

    def isatty(self):
        return True


def drawn(stream):
    """What was drawn since the last look, a line each, without what erases."""
    text = re.sub(r"\x1b\[A", "", stream.getvalue())
    stream.seek(0)
    stream.truncate()
    return [line.strip() for line in re.split(r"[\r\n]+", text) if line.strip()]


def test_time_left_in_words():
    assert left_in_words(3.0) == "a few seconds left"
    assert left_in_words(42.0) == "about 40 s left"
    assert left_in_words(250.0) == "about 4 min left"
    assert left_in_words(2 * 3600 + 11 * 60) == "about 2 h 10 min left"
    assert str(JobProgress(0.389, 245.0, "recorded 2 of 4 cameras")) == (
        "recorded 2 of 4 cameras, 38 %, about 4 min left"
    )
    assert str(JobProgress(0.0, None, "writing")) == "writing, 0 %"


def test_a_line_each_half_a_minute(monkeypatch, capsys):
    clock = Clock()
    monkeypatch.setattr(showing.LogLines.__init__, "__defaults__", (clock,))
    for quiet in (False, True):
        with Console(quiet=quiet) as console:
            for second in range(100):
                clock.now += 1
                console.pace(JobProgress(second / 100, 100.0 - second, "recorded 2 of 4 cameras"))
            console.pace(JobProgress(1.0, 0.0, "done"))
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == (0 if quiet else 3)
        if lines:
            assert lines[0] == "recorded 2 of 4 cameras, 30 %, about 70 s left"


def test_the_logger_has_lines_too(monkeypatch, caplog):
    clock = Clock()
    monkeypatch.setattr(showing.LogLines.__init__, "__defaults__", (clock,))
    watch = Watch()
    with caplog.at_level(logging.INFO, "epibar"):
        for _ in range(70):
            clock.now += 1
            watch.pace(JobProgress(0.5, 90.0, "comparing clocks"))
    assert [record.message for record in caplog.records] == ["comparing clocks, 50 %, about 2 min left"] * 2


def test_one_bar_and_rows_that_go(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    rows = (Row("cam1", 0.5, 112.4), Row("{cam2}", 0.1))
    with Console() as console:
        console.pace(JobProgress(0.2, 240.0, "recorded 0 of 2 cameras", rows))
        first = drawn(stream)
        assert [line.split()[0] for line in first] == ["recorded", "cam1", "{cam2}"]
        assert "20 %, about 4 min left" in first[0]
        assert "50 %, 112 frames/s" in first[1]
        console.pace(JobProgress(0.3, 200.0, "recorded 1 of 2 cameras", rows[1:]))
        console.pace(JobProgress(0.4, 180.0, "recorded 1 of 2 cameras", rows[1:]))
        later = drawn(stream)
        assert [line.split()[0] for line in later[-2:]] == ["recorded", "{cam2}"]
        console.note("a word in between")
        assert "a word in between" in drawn(stream)
        console.pace(JobProgress(0.5, 120.0, "matched 0 of 1 pairs"))
        console.pace(JobProgress(0.6, 110.0, "matched 0 of 1 pairs"))
        assert len(console._bars._bars) == 1
        console.pace(JobProgress(1.0, 0.0, "done"))
        assert not console._bars


def test_a_job_without_a_watch_has_a_bar_on_a_terminal(masks, tmp_path, monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    epibar.calibrate_all(masks[:2], tmp_path / "out", **FAST)
    assert any("matched 0 of 1 pairs" in line for line in drawn(stream))


def test_what_is_logged_stands_in_lines_of_its_own(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    handler = logging.StreamHandler(stream)
    logging.getLogger("epibar").addHandler(handler)
    try:
        with default_watch() as watch:
            watch.pace(JobProgress(0.2, 240.0, "matched 0 of 1 pairs"))
            drawn(stream)
            watch.warning("cam1: it shakes")
            text = stream.getvalue()
    finally:
        logging.getLogger("epibar").removeHandler(handler)
    before, _, after = text.partition("cam1: it shakes\n")
    # The bar was taken away before it and comes back after it.
    assert before.endswith("\r")
    assert not before.strip()
    assert "matched 0 of 1 pairs" in after


def test_a_program_without_a_console_has_no_bars(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    with default_watch() as watch:
        assert type(watch) is Watch
    assert not Console(quiet=False).interactive


def test_a_source_without_an_end_has_a_rate_and_no_share(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    with Console() as console:
        console.pace(JobProgress(0.2, None, "recorded 0 of 1 cameras", (Row("live", 0.0, 25.0),)))
        row = drawn(stream)[1]
    assert row.startswith("live")
    assert row.endswith("25 frames/s")
    assert "%" not in row


def test_a_step_by_itself(monkeypatch):
    stream, clock = Terminal(), Clock()
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(console_module.time, "monotonic", clock)
    with Console() as console:
        console.step("recording", 0.0)
        clock.now += 20
        console.step("recording", 0.2)
        assert "20 %, about 80 s left" in "".join(drawn(stream))
        console.step("recording", 1.0)
        assert not console._bars


def test_notebooks_have_widgets_where_they_can(monkeypatch):
    from tqdm import notebook

    made = []

    class Widget:
        def __init__(self, **given):
            made.append(given)
            self.n, self.bar_format = given["initial"], given["bar_format"]

        def refresh(self):
            pass

        def close(self):
            pass

    shell = types.SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: shell))
    assert showing.in_notebook()
    assert Console().interactive
    progress = JobProgress(0.2, None, "recorded 0 of 1 cameras", (Row("cam1", 0.5),))
    monkeypatch.setattr(notebook, "IProgress", object())
    monkeypatch.setattr(notebook, "tqdm", Widget)
    bars = showing.Bars()
    bars.show(progress)
    assert len(made) == 2
    # Without ipywidgets a cell's output is text, in which a cursor cannot go up.
    monkeypatch.setattr(notebook, "IProgress", None)
    stream = io.StringIO()
    plain = showing.Bars(stream)
    plain.show(progress)
    assert len(drawn(stream)) == 1
    plain.close()
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: None))
    assert not showing.in_notebook()
