"""report.html in a real browser: what it draws is what F says, at any width, light and dark."""

import re
from dataclasses import replace

import numpy as np
import pytest
from report_input import LATE, calibrated, make_report_input

from epibar.clocks import Timing
from epibar.report.page import write_report

DESKTOP = {"width": 1280, "height": 900}
PHONE = {"width": 390, "height": 844}
PAIRS = 3


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    cameras, pairs = make_report_input()
    return write_report(folder / "report.html", cameras, pairs, ["cam9.mp4: no such file"]), pairs


@pytest.fixture
def opened(watched, report):
    """Open the report at a pair."""
    return lambda viewport=DESKTOP, pair=1, **options: watched(
        f"{report[0].as_uri()}#pair-{pair}", viewport, **options
    )


def test_the_clocks_are_told(browser, tmp_path):
    cameras, pairs = make_report_input()
    slow, fast = Timing(), Timing(frames_per_frame=1.2 * (1 - 50e-6))
    for timing, offset, words in (
        (slow, 7.0, "Frame i of A is frame i + 7 of B."),
        (fast, -3.25, "Frame i of A is frame 1.19994 × i − 3.25 of B."),
        (fast, 0.0, "Frame i of A is frame 1.19994 × i + 0 of B."),
    ):
        calibration = replace(pairs[0].calibration, timing=timing, time_offset=offset)
        path = write_report(
            tmp_path / "report.html", cameras, [replace(pairs[0], calibration=calibration), *pairs[1:]]
        )
        page = browser.new_page()
        page.goto(f"{path.as_uri()}#pair-1")
        assert page.get_by_text(words, exact=True).count() == 1
        page.close()


def size_of(letter):
    """The two cameras differ in size."""
    return calibrated()[1]["AB".index(letter)].size


def place_on_screen(page, letter, x, y):
    """Client coordinates near a pixel of a view, whole numbers, and the pixel that is really there."""
    view = page.locator(f"svg[data-view={letter}]")
    view.scroll_into_view_if_needed()
    box = view.bounding_box()
    scale = box["width"] / size_of(letter)[0]
    client = round(box["x"] + (x + 0.5) * scale), round(box["y"] + (y + 0.5) * scale)
    return client, ((client[0] - box["x"]) / scale - 0.5, (client[1] - box["y"]) / scale - 0.5)


def drawn_line(page, letter):
    line = page.locator(f"svg[data-view={letter}] .pointed .core")
    return np.array([[float(line.get_attribute(f"{axis}{end}")) for axis in "xy"] for end in "12"])


def assert_epipolar(ends, line, letter):
    """The ends lie on the line and on the border of the image."""
    width, height = size_of(letter)
    distance = np.abs(ends @ line[:2] + line[2]) / np.hypot(line[0], line[1])
    assert distance.max() < 0.5
    gap = [min(abs(x + 0.5), abs(x - width + 0.5), abs(y + 0.5), abs(y - height + 0.5)) for x, y in ends]
    assert max(gap) < 1e-6
    assert np.linalg.norm(ends[0] - ends[1]) > 20


def expected_line(F, letter, place):
    return (F if letter == "A" else F.T) @ np.append(place, 1.0)


def crosses(line, size):
    x = np.linspace(5, size[0] - 6, 200)
    with np.errstate(divide="ignore"):
        y = -(line[0] * x + line[2]) / line[1]
    return np.any((y > 5) & (y < size[1] - 6))


def telling_places(F, letter):
    """Pixels, far apart, whose lines cross the other image."""
    grid = [(x, y) for x in (40, 100, 200, 290) for y in (40, 110, 170, 220)]
    other = size_of("B" if letter == "A" else "A")
    found = [place for place in grid if crosses(expected_line(F, letter, place), other)]
    assert len(found) >= 4
    return found[:: max(1, len(found) // 4)]


# --- the pointer ---


@pytest.mark.parametrize(("letter", "other"), [("A", "B"), ("B", "A")])
def test_pointing_at_one_view_draws_the_line_of_F_in_the_other(opened, report, letter, other):
    page = opened()
    F = report[1][0].calibration.F
    for x, y in telling_places(F, letter):
        client, place = place_on_screen(page, letter, x, y)
        page.mouse.move(*client)
        assert_epipolar(drawn_line(page, other), expected_line(F, letter, place), other)
        assert page.locator(f"svg[data-view={letter}] .pointed .core").count() == 0
        shown = re.search(rf"{letter} \(([-\d.]+), ([-\d.]+)\)", page.locator(".readout").inner_text())
        assert np.allclose([float(value) for value in shown.groups()], place, atol=0.11)


def test_a_finger_and_the_arrow_keys_point_too(opened, report):
    page = opened(PHONE, has_touch=True)
    F = report[1][0].calibration.F
    x, y = telling_places(F, "A")[1]
    client, place = place_on_screen(page, "A", x, y)
    page.touchscreen.tap(*client)
    assert_epipolar(drawn_line(page, "B"), expected_line(F, "A", place), "B")
    page.locator("svg[data-view=A]").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowUp")
    assert_epipolar(drawn_line(page, "B"), expected_line(F, "A", (place[0] + 1, place[1] - 10)), "B")


def test_the_coloured_lines_pass_through_both_views(opened, report):
    page = opened()
    F = report[1][0].calibration.F
    ends = [
        page.locator(f"svg[data-view={letter}] .lines line.core").evaluate_all(
            "lines => lines.map(l => ['x1', 'y1', 'x2', 'y2'].map(k => Number(l.getAttribute(k))))"
        )
        for letter in "AB"
    ]
    assert len(ends[0]) == len(ends[1]) >= 4
    for (x0, y0, x1, y1), b in zip(*ends, strict=True):
        assert_epipolar(np.reshape(b, (2, 2)), expected_line(F, "A", ((x0 + x1) / 2, (y0 + y1) / 2)), "B")
    page.get_by_role("combobox").select_option(label="no lines")
    assert page.locator(".lines line").count() == 0
    assert not page.locator(".strips").is_visible()


# --- time ---


def test_the_slider_shows_other_moments_in_both_views(opened, report):
    page = opened()
    slider, points = page.locator("#moment"), report[1][0].calibration.frontier_points
    last = int(slider.get_attribute("max"))
    assert last >= 11
    seen = []
    for index in (0, last // 2, last):
        slider.fill(str(index))
        frames = [
            int(re.search(r"frame (\d+)", text).group(1))
            for text in page.locator(".views figcaption").all_inner_texts()
        ]
        assert frames[1] == frames[0] + LATE
        assert page.locator("svg[data-view=A] .points circle").count() == (points.frame == frames[0]).sum()
        href = page.locator("svg[data-view=A] > image").get_attribute("href")
        assert href.startswith("data:image/jpeg")
        seen.append((frames[0], href))
        assert f"frame {frames[1]} of B" in slider.get_attribute("aria-valuetext")
    assert len(set(seen)) == 3
    assert [frame for frame, _ in seen] == sorted(frame for frame, _ in seen)
    slider.focus()
    page.keyboard.press("ArrowLeft")
    assert slider.input_value() == str(last - 1)


def test_frontier_points_can_be_hidden(opened, report):
    page = opened()
    points = report[1][0].calibration.frontier_points
    circle = page.locator("svg[data-view=B] .points circle").first
    assert circle.is_visible()
    frame = int(re.search(r"frame (\d+)", page.locator(".views figcaption").first.inner_text()).group(1))
    shown = [float(circle.get_attribute(name)) for name in ("cx", "cy")]
    assert np.allclose(shown, points.b[points.frame == frame][0], atol=1e-3)
    page.get_by_label("frontier points").uncheck()
    assert not circle.is_visible()


# --- the page ---


def drawn_charts(page):
    """Scroll to one chart after the other, until it is drawn; each wait has an end."""
    plots = page.locator(".plot")
    for index in range(plots.count()):
        plots.nth(index).scroll_into_view_if_needed()
        plots.nth(index).locator(".main-svg").first.wait_for()
    return plots.count()


@pytest.mark.parametrize("pair", range(1, PAIRS + 1))
def test_a_phone_shows_every_pair_without_scrolling_sideways(opened, pair):
    page = opened(PHONE, pair)
    assert drawn_charts(page) >= 3
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]


def test_every_chart_is_drawn_and_only_when_it_is_scrolled_to(opened):
    page = opened({"width": 1280, "height": 400})
    assert page.evaluate("window.Plotly === undefined")
    assert drawn_charts(page) == 7  # barcodes, time shift, residuals, two heat maps, two error maps
    titles = page.locator(".card h3").all_inner_texts()
    assert {"Motion barcodes of the lines", "Time shift", "Residuals of the frontier points"} <= set(titles)


def test_the_matrix_leads_to_each_pair(opened):
    page = opened()
    for index, names in enumerate((("cam1", "cam2"), ("cam1", "cam3"), ("cam2", "cam3")), 1):
        page.locator(f"a.cell[href='#pair-{index}']").click()
        page.locator(f"a.cell[href='#pair-{index}'][aria-current]").wait_for()
        assert page.locator("#pair-title .who").all_inner_texts() == [f"A {names[0]}", f"B {names[1]}"]


def copied(page):
    page.evaluate("navigator.clipboard.writeText = async text => { window.copied = text; }")
    page.get_by_role("button", name="Copy F").click()
    page.get_by_role("button", name="Copied").wait_for()
    return page.evaluate("window.copied")


def test_F_is_copied_whole(opened, report):
    names = {"np": np}
    exec(copied(opened()), names)
    assert (names["F"] == report[1][0].calibration.F).all()


def test_a_refused_pair_looks_refused(opened):
    page = opened(pair=2)
    verdict = page.locator(".verdict")
    assert "Refused: ambiguous" in verdict.inner_text()
    assert "What to do next" in verdict.inner_text()
    assert "px expected error" not in verdict.inner_text()
    assert not page.locator(".F").is_visible()
    colours = page.locator(".lines line.core").evaluate_all("l => l.map(x => x.getAttribute('stroke'))")
    assert set(colours) == {"#b9bec6"}
    banner = "getComputedStyle(document.querySelector('.frame'), '::before').content"
    assert "refused" in page.evaluate(banner)
    page.get_by_text("The refused matrix").click()
    assert copied(page).startswith("# REFUSED (ambiguous)")


def test_a_pair_of_which_a_camera_moved(watched, tmp_path):
    cameras, pairs = make_report_input()
    moved = replace(pairs[2].calibration, kind="moved", reason="cam3 moved after the pair was calibrated")
    path = write_report(tmp_path / "report.html", cameras, [replace(pairs[2], calibration=moved)])
    said = watched(f"{path.as_uri()}#pair-1", DESKTOP).locator(".verdict").inner_text()
    assert "a camera has moved since" in said
    assert "is of before a camera moved" in said
    assert "No fundamental matrix" not in said


def test_a_pair_without_a_matrix_has_no_pointer(opened):
    page = opened(pair=3)
    assert "No fundamental matrix was found" in page.locator(".verdict").inner_text()
    client, _ = place_on_screen(page, "A", 100, 100)
    page.mouse.move(*client)
    assert page.locator(".pointed .core").count() == 0
    assert page.locator("svg[data-view=B] .hulls polygon").count() > 0


def brightness(page, element="body", name="backgroundColor"):
    colour = page.evaluate(f"getComputedStyle(document.querySelector({element!r})).{name}")
    return sum(float(value) for value in re.findall(r"[\d.]+", colour)[:3]) / 3


def test_dark_and_light(opened):
    dark, light = opened(color_scheme="dark"), opened(color_scheme="light")
    assert brightness(dark) < 60 < 200 < brightness(light)
    for page, label in ((dark, "Switch to light colours"), (light, "Switch to dark colours")):
        drawn_charts(page)
        text = ".strip-plot .xtick text"
        before, ink = brightness(page), brightness(page, text, "fill")
        assert abs(before - ink) > 130
        page.get_by_role("button", name=label).click()
        assert abs(brightness(page) - before) > 130
        assert abs(brightness(page, text, "fill") - ink) > 130


def test_the_overview_is_there_without_scripts(browser, report):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(report[0].as_uri())
    assert page.locator("a.cell").count() == PAIRS
    assert page.get_by_text("need JavaScript").is_visible()
    assert not page.locator("#pair").is_visible()
    context.close()
