"""The network of report.html in a real browser: what is drawn where, turned, picked, on a phone."""

import time

import numpy as np
import pytest
from network_input import COVARIANCE
from network_report_input import cameras, large_report, network, network_report, renamed, walkers
from report_input import make_report_input
from test_report import Page

from epibar.report import NetworkReport
from epibar.report.page import write_report

DESKTOP = {"width": 1280, "height": 900}
PHONE = {"width": 390, "height": 844}
VIEW = "svg.space-view"
APEX = f"{VIEW} .station .apex"


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    shown, made = network_report()
    return write_report(tmp_path_factory.mktemp("report") / "report.html", shown, [], network=made).as_uri()


def drawn(page):
    page.locator(APEX).first.wait_for()
    return page


def settled(page):
    """Wait for what the last event asked to be drawn."""
    page.evaluate(
        """() => new Promise((done, fail) => {
            setTimeout(fail, 30000, new Error("nothing was drawn in 30 seconds"));
            requestAnimationFrame(() => requestAnimationFrame(done));
        })"""
    )


def places(page):
    """Where each camera is drawn, by the beginning of its name, CSS pixels."""
    settled(page)
    found = page.locator(f"{VIEW} .station").evaluate_all(
        """stations => stations.map(one => [one.querySelector("title").textContent.split(":")[0],
            ["cx", "cy"].map(name => Number(one.querySelector(".apex").getAttribute(name)))])"""
    )
    return {name: np.array(place) for name, place in found}


def test_from_above_it_is_a_map(watched, report):
    page = drawn(watched(report, DESKTOP))
    page.get_by_role("button", name="From above").click()
    seen, made = places(page), network()
    assert set(seen) == {"cam1", "cam2", "cam3", "cam5"}
    floor = np.array([[*made.cameras[name].position[:2], 1.0] for name in seen])
    pixels = np.array(list(seen.values()))
    # All cameras are equally high, so perspective changes nothing: a similarity, x right, y up.
    found, *_ = np.linalg.lstsq(floor, pixels, rcond=None)
    assert np.abs(floor @ found - pixels).max() < 0.5
    scale = found[0, 0]
    assert scale > 100
    assert np.allclose(found[:2], [[scale, 0], [0, -scale]], atol=1e-3 * scale)


def test_from_the_side_high_is_up(watched, report):
    page = drawn(watched(report, DESKTOP))
    page.get_by_role("button", name="From the side").click()
    settled(page)
    feet = page.locator(f"{VIEW} .drops path").evaluate_all("all => all.map(one => one.getAttribute('d'))")
    assert len(feet) == 4
    for way in feet:
        camera, foot = (np.array(end.split(","), float) for end in way[1:].split("L"))
        assert foot[1] > camera[1] + 50
        assert abs(foot[0] - camera[0]) < 0.2


@pytest.mark.parametrize("size", [DESKTOP, PHONE])
def test_names_of_many_cameras_do_not_lie_over_one_another(watched, tmp_path, size):
    made = network(20, refused=(), lost=())
    path = write_report(tmp_path / "r.html", cameras(made.cameras), [], network=NetworkReport(made))
    page = drawn(watched(path.as_uri(), size))
    names = page.locator(f"{VIEW} .names text")

    def boxes():
        settled(page)
        return names.evaluate_all(
            "all => all.map(one => one.getBBox()).map(b => [b.x, b.x + b.width, b.y + 3, b.y + b.height - 3])"
        )

    found = boxes()
    assert 7 < len(found) <= 20
    for k, (left, right, top, bottom) in enumerate(found):
        for other in found[:k]:
            assert left > other[1] or other[0] > right or top > other[3] or other[2] > bottom
    # Whoever is left out is named when its row is looked at.
    hidden = sorted(set(made.cameras) - set(names.all_text_contents()))
    for name in hidden[:1]:
        page.locator(f"tr[data-camera={name}]").focus()
        settled(page)
        assert name in names.all_text_contents()
    assert hidden or size is DESKTOP


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    return large_report(tmp_path_factory.mktemp("large") / "report.html")


def test_twenty_cameras_stay_below_25_megabytes(large):
    assert 8_000_000 < large.stat().st_size < 25_000_000
    space = Page(large).data["space"]
    assert len(space["pairs"]) == 190
    assert all(pair["pair"] is not None for pair in space["pairs"])
    assert 6_000 < sum(map(len, space["tracks"])) <= 13_000


def test_twenty_cameras_and_all_their_pairs_open_and_turn(watched, large):
    """How long it takes is printed (`pytest -s`): it is the machine's as much as the page's."""
    moments = [time.perf_counter()]
    page = drawn(watched(large.as_uri(), DESKTOP))
    start = places(page)
    moments.append(time.perf_counter())
    assert len(start) == 20
    assert page.locator(".network-cameras tbody tr").count() == 20
    assert page.locator(".matrix a.cell").count() == 190
    assert page.locator(f"{VIEW} .links .link").count() == 190
    view = page.locator(VIEW)
    view.focus()
    moments.append(time.perf_counter())
    for _ in range(10):
        page.keyboard.press("ArrowRight")
        turned = places(page)
        assert max(np.linalg.norm(turned[name] - start[name]) for name in start) > 2
        start = turned
    moments.append(time.perf_counter())
    page.locator(".matrix a.cell").last.click()
    page.locator("a.cell[href='#pair-190'][aria-current]").wait_for()
    moments.append(time.perf_counter())
    assert page.locator("#pair-title .who").all_inner_texts() == ["A cam19", "B cam20"]
    opened, _, turns, pair = np.diff(moments)
    told = f"drawn in {opened:.2f} s, a turn {turns / 10:.2f} s, a pair {pair:.2f} s"
    print(f"20 cameras, 190 pairs: {told}")  # noqa: T201


def test_everything_is_inside_from_whichever_side(watched, report):
    page = drawn(watched(report, DESKTOP))
    view = page.locator(VIEW)
    box = view.bounding_box()
    view.focus()
    for _ in range(8):
        for _ in range(3):
            page.keyboard.press("Shift+ArrowLeft")
        settled(page)
        edge = view.locator("path").evaluate_all(
            """all => all.filter(one => one.getTotalLength() > 0).map(one => one.getBBox())
                .map(b => [b.x, b.y, b.x + b.width, b.y + b.height])"""
        )
        edge = np.array(edge)
        assert edge[:, :2].min() >= 0
        assert edge[:, 2].max() <= box["width"]
        assert edge[:, 3].max() <= box["height"]


def test_keys_and_pointer_turn_and_magnify_it(watched, report):
    page = drawn(watched(report, DESKTOP))
    view = page.locator(VIEW)
    start = places(page)
    view.focus()
    page.keyboard.press("ArrowRight")
    turned = places(page)
    assert not np.allclose(turned["cam1"], start["cam1"], atol=2)
    page.keyboard.press("ArrowLeft")
    assert np.allclose(places(page)["cam1"], start["cam1"], atol=0.1)
    page.keyboard.press("+")
    wider = places(page)
    assert np.linalg.norm(wider["cam1"] - wider["cam5"]) > 1.2 * np.linalg.norm(start["cam1"] - start["cam5"])
    page.keyboard.press("0")
    assert np.allclose(places(page)["cam1"], start["cam1"], atol=0.1)
    box = view.bounding_box()
    page.mouse.move(box["x"] + 40, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + 140, box["y"] + 40, steps=4)
    page.mouse.up()
    assert not np.allclose(places(page)["cam1"], start["cam1"], atol=10)


def test_pairs_have_the_colour_of_their_verdict(watched, report):
    page = drawn(watched(report, DESKTOP))
    lines = page.locator(f"{VIEW} .links .link")
    assert lines.count() == 6
    names = ("confirmed", "predicted", "contradicts")
    colours = [
        page.locator(f"{VIEW} .links .link.{name}").first.evaluate("one => getComputedStyle(one).stroke")
        for name in names
    ]
    assert len(set(colours)) == 3
    assert page.locator(f"{VIEW} .links title").last.text_content().startswith("cam1 and cam2: contradicts")
    assert page.locator(".space-legend li").count() == 3
    page.get_by_role("checkbox", name="pairs").uncheck()
    settled(page)
    assert lines.count() == 0
    page.get_by_label("position errors").uncheck()
    settled(page)
    assert page.locator(f"{VIEW} .station .error").count() == 0
    assert page.locator(f"{VIEW} .tracks path").count() == 3
    page.get_by_label("walkers").uncheck()
    settled(page)
    assert page.locator(f"{VIEW} .tracks path").count() == 0


def test_a_line_leads_to_its_pair(watched, tmp_path):
    shown, pairs = make_report_input()
    made = network(3, refused=(), lost=())
    path = write_report(tmp_path / "r.html", shown, pairs, network=NetworkReport(made, None, walkers()))
    page = drawn(watched(path.as_uri(), DESKTOP))
    assert page.locator(f"{VIEW} .to-pair").count() == 3
    page.locator(f"{VIEW} .to-pair").first.dispatch_event("click")
    page.locator("a.cell[href='#pair-2'][aria-current]").wait_for()
    assert page.locator("#pair-title .who").all_inner_texts() == ["A cam1", "B cam3"]
    assert page.get_by_text("of 3 cameras accepted", exact=False).first.is_visible()
    assert page.get_by_text("refused here does not speak against the network").is_visible()


def test_an_ellipsoid_is_the_stated_error_enlarged(watched, report):
    page = drawn(watched(report, DESKTOP))
    page.get_by_role("button", name="From above").click()
    seen = places(page)
    made = network()
    length = np.linalg.norm(made.cameras["cam1"].position - made.cameras["cam5"].position)
    per_unit = np.linalg.norm(seen["cam1"] - seen["cam5"]) / length
    ellipses = page.locator(f"{VIEW} .station .error")
    radii = np.array([[float(one.get_attribute(key)) for key in ("rx", "ry")] for one in ellipses.all()])
    assert len(radii) == 3, "that of a refused camera is not known"
    # From above one that is alike in all directions is a circle, but for the perspective beside the middle.
    longer = radii[:, 0] / radii[:, 1]
    assert sorted(longer.round(1)) == pytest.approx([1.0, 1.0, 3.0], abs=0.2)
    alike = radii[longer < 2]
    assert np.allclose(alike[:, 1], 20 * 0.002 * per_unit, rtol=1e-2)
    along_x = 20 * 2.5 * np.sqrt(COVARIANCE[0, 0]) * per_unit
    assert radii[longer > 2][0, 0] == pytest.approx(along_x, rel=0.1)
    turned = ellipses.nth(int(longer.argmax())).get_attribute("transform")
    across = seen["cam5"] - seen["cam1"]
    made_across = (made.cameras["cam5"].position - made.cameras["cam1"].position)[:2]
    of_x = np.degrees(np.arctan2(*across[::-1]) + np.arctan2(*made_across[::-1]))
    found = float(turned.split("rotate(")[1].rstrip(")"))
    assert abs((found - of_x + 90) % 180 - 90) < 10, "along x"


def test_a_row_picks_its_camera(watched, report):
    page = drawn(watched(report, DESKTOP))
    page.locator("tr[data-camera=cam1]").hover()
    settled(page)
    faded = page.locator(f"{VIEW} .station.faded title").all_text_contents()
    assert sorted(faded) == ["cam2", "cam3: left out", "cam5"]
    page.locator("tr[data-camera=cam4]").hover()
    settled(page)
    assert page.locator(f"{VIEW} .faded").count() == 0, "it has no place, so nothing is picked"
    page.locator("tr[data-camera=cam2]").focus()
    settled(page)
    assert "cam2" not in page.locator(f"{VIEW} .station.faded title").all_text_contents()
    assert page.locator(f"{VIEW} .station.faded").count() == 3


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_it_without_scrolling_sideways(watched, report, scheme):
    page = drawn(watched(report, PHONE, color_scheme=scheme, has_touch=True))
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
    table = page.locator(".network-cameras").bounding_box()
    assert table["x"] >= 0
    assert table["x"] + table["width"] <= PHONE["width"]
    fill = page.locator(f"{VIEW} .names text").first.evaluate("one => getComputedStyle(one).fill")
    brightness = sum(map(int, fill.removeprefix("rgb(").removesuffix(")").split(","))) / 3
    assert (brightness > 180) is (scheme == "dark")


def test_names_are_text(watched, tmp_path):
    evil = "<b>x</b>&amp;<img src=x onerror=alert(1)> and so on and so forth"
    made = renamed(network(), {name: name for name in network().cameras} | {"cam1": evil})
    path = write_report(tmp_path / "r.html", cameras(made.cameras), [], network=NetworkReport(made))
    page = drawn(watched(path.as_uri(), PHONE))
    assert f"{evil[:21]}…" in page.locator(f"{VIEW} .names text").all_text_contents()
    assert evil in page.locator(f"{VIEW} .station title").all_text_contents()
    assert page.locator(".network-cameras tbody th").first.text_content() == evil
    assert page.locator("main img, main b").count() == 0
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]


def test_without_scripts_the_table_is_there(browser, report):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(report)
    assert page.locator(".network-cameras tbody tr").count() == 5
    assert not page.locator("#space").is_visible()
    assert page.get_by_text("The network in space and the views of each pair need JavaScript").is_visible()
    context.close()
