"""Take the pictures of the report of ``epibar demo``: ``docs/report_desktop.png``, ``_phone`` and ``_pair``.

Run ``.venv/bin/python docs/make_screenshots.py`` from the root of the repository, after ``make build``. With
a report as its argument it takes that one. It needs Playwright and a Chromium.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from epibar.cli import main as epibar

FOLDER = Path(__file__).parent
LIMIT = 400_000
"""Bytes per picture."""


def save(png: bytes, path: Path) -> None:
    """Write a picture in 256 colours; an octree keeps the rare ones, which are the lines."""
    image = Image.open(io.BytesIO(png)).convert("RGB")
    image.quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(path, optimize=True)
    if path.stat().st_size > LIMIT:
        raise SystemExit(f"{path}: {path.stat().st_size} bytes, above the limit of {LIMIT}")


def take(browser: Browser, report: Path) -> None:
    """Photograph the network at the width of a desktop and of a phone, and the views of a pair."""
    address = report.resolve().as_uri()
    desktop = browser.new_page(viewport={"width": 1280, "height": 1206}, color_scheme="light")
    desktop.goto(address)
    desktop.locator(".space-view .apex").first.wait_for()
    save(desktop.screenshot(), FOLDER / "report_desktop.png")

    phone = browser.new_page(
        viewport={"width": 390, "height": 844}, color_scheme="dark", device_scale_factor=1.5, has_touch=True
    )
    phone.goto(address)
    phone.locator(".space-view .apex").first.wait_for()
    show(phone, ".space-card")
    save(phone.screenshot(), FOLDER / "report_phone.png")

    # A pair that was accepted by itself, where there is one.
    accepted = desktop.locator("a.cell.accepted")
    if accepted.count():
        accepted.first.click()
        desktop.mouse.move(2, 2)
    desktop.locator(".strip-plot .main-svg").first.wait_for()
    show(desktop, "#pair")
    save(desktop.screenshot(), FOLDER / "report_pair.png")


def show(page: Page, selector: str) -> None:
    """Scroll to a part of the page."""
    page.locator(selector).evaluate("part => scrollTo(0, part.getBoundingClientRect().top + scrollY - 12)")
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def main() -> None:
    """Make the report, unless one is given, and photograph it."""
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        if len(sys.argv) > 1:
            report = Path(sys.argv[1])
        else:
            if code := epibar(["demo", "--out", folder, "--quiet"]):
                raise SystemExit(code)
            report = Path(folder) / "report.html"
        browser = playwright.chromium.launch(executable_path=chromium)
        take(browser, report)
        browser.close()


if __name__ == "__main__":
    main()
