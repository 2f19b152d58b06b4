"""What several files of tests ask for: a real browser, and what stands for the compiled module.

Tests in the browser are skipped where there is none.
"""

import shutil

import pytest
from check_input import stand_in
from extended_input import stand_in_adding
from network_input import WORDS, write_masks
from pairs_input import calibrated_pairs, people, recorded

from epibar import export
from epibar.cli import main

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")


@pytest.fixture(scope="module")
def browser():
    """A Chromium of the system, or else Playwright's own."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync_api.sync_playwright() as playwright:
        try:
            opened = playwright.chromium.launch(executable_path=found)
        except sync_api.Error as error:
            if found:
                raise
            pytest.skip(
                f"no Chromium: install one, or run 'playwright install chromium' ({error.message[:80]})"
            )
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def network_masks(tmp_path_factory):
    """Ready masks of three cameras that are one network."""
    return write_masks(tmp_path_factory.mktemp("masks"))


@pytest.fixture(scope="session")
def network_run(network_masks, tmp_path_factory):
    """A run of these, of which nothing is known."""
    out = tmp_path_factory.mktemp("run") / "out"
    assert main(["calibrate", *network_masks, "--out", str(out), *WORDS, "--quiet"]) == 0
    return out


@pytest.fixture(scope="module")
def masks(network_masks):
    """The same; other files have their own of that name."""
    return list(network_masks)


@pytest.fixture(scope="module")
def scene():
    """Three cameras before people, whose pairs are calibrated; other files have their own of these names."""
    return people()


@pytest.fixture(scope="module")
def recordings():
    return recorded()


@pytest.fixture(scope="module")
def calibrations():
    return calibrated_pairs()


@pytest.fixture(scope="module")
def run(recordings, calibrations):
    """What exports read of these."""
    return export.Run.of(recordings, calibrations)


@pytest.fixture
def again(done, tmp_path):
    """A copy of the folder of a run, which the file of the test has as ``done``."""
    return shutil.copytree(done, tmp_path / "again")


@pytest.fixture
def core(monkeypatch):
    """Stands for the compiled module where footage is checked against a network."""
    return stand_in(monkeypatch)


@pytest.fixture
def adding(core, monkeypatch):
    """Stands for it where a camera is added to one."""
    return stand_in_adding(monkeypatch)


@pytest.fixture
def watched(browser):
    """Open pages; whatever the browser complains about or asks the network for fails the test."""
    complaints, contexts = [], []

    def open_page(address, viewport, **options):
        contexts.append(browser.new_context(viewport=viewport, **options))
        page = contexts[-1].new_page()
        page.on("console", lambda message: complaints.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on(
            "request",
            lambda request: (
                None if request.url.startswith(("file:", "data:")) else complaints.append(request.url)
            ),
        )
        page.goto(address)
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert complaints == []
