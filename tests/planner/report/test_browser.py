"""The pages in a real browser: clicked through, with no error on the console and nothing fetched."""

import itertools
import shutil

import numpy as np
import pytest

from topple.planner.execution.demo import demo
from topple.planner.report.plan_page import plan_page
from topple.planner.report.run_page import run_page
from topple.planner.report.show import show_page
from topple.robots.scenarios import SCENARIOS
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene

api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install playwright")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here: apt-get install chromium")

FLAGS = "--no-sandbox --use-angle=swiftshader --disable-quic --no-first-run".split()
FLAGS += "--disable-background-networking --disable-component-update --disable-sync".split()
PLAIN = ["--disable-gpu", "--disable-software-rasterizer"]  # no WebGL


@pytest.fixture(scope="module")
def playwright():
    with api.sync_playwright() as started:
        yield started


@pytest.fixture(scope="module")
def browser(playwright):
    # without WebGL, which software draws in three times the time; what differs is tested with both
    opened = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", *PLAIN])
    yield opened
    opened.close()


@pytest.fixture
def open_page(browser, tmp_path):
    """Opens HTML from a file; at the end nothing may have been complained about or fetched."""
    wrong, fetched = [], []
    context = browser.new_context(viewport={"width": 640, "height": 600})

    def opener(html):
        file = tmp_path / "page.html"
        file.write_text(html, encoding="utf-8")
        page = context.new_page()
        page.on("console", lambda m: wrong.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda request: fetched.append(request.url))
        page.goto(file.as_uri())
        settle(page)
        return page

    yield opener
    context.close()
    assert wrong == []
    assert [url for url in fetched if not url.startswith(("file:", "data:"))] == []


HEAVIEST = 1_500_000  # bytes of a page
GRAVE = ("serious", "critical")
UNFOLD = "() => document.querySelectorAll('details').forEach((e) => { e.open = true; })"
SMALLEST = """() => Math.min(...[...document.querySelectorAll("body *")]
  .filter((e) => e.checkVisibility())
  .filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()))
  .map((e) => parseFloat(getComputedStyle(e).fontSize)))"""


PAINTED = """(canvas) => {
  const paper = new OffscreenCanvas(canvas.width, canvas.height);
  const copy = paper.getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, canvas.width, canvas.height).data;
  return data.filter((value, i) => i % 4 === 3 && value > 0).length / (data.length / 4);
}"""


def settle(page):
    """Waits until the view has drawn what it was asked to, finely."""
    page.wait_for_function(
        "() => window.panels.every((each) => !each || !each.viewer.busy || each.player?.playing)"
    )
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def pixels(page):
    """A checksum of what the visible view shows, drawn anew: letters change as a canvas is first read."""
    settle(page)
    return page.evaluate("""() => {
      const { viewer } = window.panels.find((each) => each && each.viewer.canvas.clientWidth > 0);
      const { width, height } = viewer.canvas;
      const copy = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
      let sum = 0;
      for (let k = 0; k < 3; k++) {
        viewer.draw();
        copy.clearRect(0, 0, width, height);
        copy.drawImage(viewer.canvas, 0, 0);
        sum = copy.getImageData(0, 0, width, height).data.reduce((all, value) => (all * 31 + value) >>> 0, 0);
      }
      return sum;
    }""")


def test_the_view_turns_zooms_moves_and_comes_back(open_page, stack):
    page = open_page(show_page(*stack))
    page.locator("canvas").scroll_into_view_if_needed()
    box = page.locator("canvas").bounding_box()
    x, y = box["x"] + 60, box["y"] + 60
    seen = [pixels(page)]
    for act in ("drag", "shift", "wheel", "key"):
        page.mouse.move(x, y)
        if act == "wheel":
            page.mouse.wheel(0, -300)
        elif act == "key":
            page.locator("canvas").press("ArrowLeft")
        else:
            if act == "shift":
                page.keyboard.down("Shift")
            page.mouse.down()
            page.mouse.move(x + 80, y + 30, steps=4)
            page.mouse.up()
            page.keyboard.up("Shift")
        page.mouse.move(x, y)
        seen.append(pixels(page))
    assert len(set(seen)) == len(seen)
    page.click("[data-reset]")
    page.mouse.move(1, 1)
    page.evaluate("() => window.panels[0].light([])")
    assert pixels(page) == seen[0]


def test_every_switch_changes_the_picture(open_page, stack):
    page = open_page(show_page(*stack))
    before = pixels(page)
    for box in page.locator(".switches input").all():
        on = box.is_checked()
        box.set_checked(not on)
        assert pixels(page) != before, box.get_attribute("data-show")
        box.set_checked(on)
    assert pixels(page) == before


def test_a_click_keeps_an_object_lit_with_its_relations(open_page, stack):
    scene = stack[0]
    page = open_page(show_page(*stack))
    number = scene.names.index("crate")
    page.locator(f'ol.order li[data-object="{number}"]').click()
    page.mouse.move(1, 1)
    assert page.locator(".info b").inner_text() == "crate"
    assert "before" in page.locator(".info").inner_text() or "after" in page.locator(".info").inner_text()
    assert page.locator("tr.lit").count() > 0
    page.locator("canvas").scroll_into_view_if_needed()
    at = page.evaluate(
        """(number) => { const v = window.panels[0].viewer, box = v.canvas.getBoundingClientRect();
        const [x, y] = v.project(v.scene.objects[number].centre);
        return [box.left + x / v.scale, box.top + y / v.scale]; }""",
        scene.names.index("beside"),
    )
    page.mouse.click(*at)
    assert page.locator(".info b").inner_text() == "beside"
    page.mouse.click(*at)
    page.mouse.move(1, 1)
    assert not page.locator(".info").is_visible()


def test_the_steps_of_a_run_turn_by_mark_button_and_key(open_page, run_record):
    page = open_page(run_page(run_record))
    sections = page.locator("section.step")

    def shown():
        return [i for i in range(sections.count()) if sections.nth(i).is_visible()]

    assert shown() == [0]
    images = sections.nth(0).locator("img")
    assert images.count() == 2 and all(
        image.evaluate("(e) => e.naturalWidth") == 64 for image in images.all()
    )
    views = {pixels(page)}
    page.keyboard.press("ArrowRight")
    assert shown() == [1]
    views.add(pixels(page))
    page.locator(".timeline button").last.click()
    assert shown() == [2]
    views.add(pixels(page))
    assert len(views) == 3
    page.keyboard.press("ArrowRight")
    assert shown() == [2]
    sections.nth(2).get_by_text("previous").click()
    assert shown() == [1]
    page.keyboard.press("Home")
    assert shown() == [0]


def test_pages_are_readable_at_every_width_and_in_the_dark(
    open_page, photographed, stack, run_record, lone_plan
):
    pages = show_page(*photographed), show_page(*stack), run_page(run_record), plan_page(*lone_plan)
    for html in pages:
        page = open_page(html)
        for width, colours in itertools.product((1300, 400), ("light", "dark")):
            check_readable(page, width, colours)
        page.close()


def check_readable(page, width, colours):
    page.set_viewport_size({"width": width, "height": 900})
    page.emulate_media(color_scheme=colours)
    page.evaluate(UNFOLD)
    settle(page)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(SMALLEST) >= 12
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed")
    found = axe.Axe().run(page).response["violations"]
    assert [(rule["id"], rule["nodes"][0]["html"]) for rule in found if rule["impact"] in GRAVE] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SCENARIOS))
def test_the_page_of_each_scene_is_small_and_readable_at_every_step(open_page, tmp_path, name):
    demo(name, folder=tmp_path)
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert len(html) < HEAVIEST
    page = open_page(html)
    for width, colours in itertools.product((1300, 400), ("light", "dark")):
        for _ in page.locator("section.step").all():
            check_readable(page, width, colours)
            assert page.locator("section.step:visible canvas").evaluate(PAINTED) > 0.2
            page.keyboard.press("PageDown")
        page.keyboard.press("Home")


def test_seventeen_objects_are_there_with_and_without_webgl(playwright, tmp_path):
    rng = np.random.default_rng(0)
    boxes = {
        f"box {n}": rng.uniform(0, 0.08, (9000, 3)) + np.array([n % 5, n // 5, 0]) * 0.1 for n in range(17)
    }
    scene = Scene(boxes, up=[0, 0, 1])
    file = tmp_path / "page.html"
    file.write_text(show_page(scene, relate(scene)), encoding="utf-8")
    for flags, light in ((FLAGS, True), (PLAIN, False)):
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", *flags])
        page = opened.new_page()
        page.goto(file.as_uri())
        settle(page)
        assert page.evaluate("() => Boolean(Light.get())") is light
        assert page.locator("canvas").evaluate(PAINTED) > 0.05
        before = pixels(page)
        page.locator("canvas").press("ArrowLeft")
        assert pixels(page) != before
        opened.close()


def test_a_slider_goes_from_before_to_after(open_page, run_record):
    page = open_page(run_page(run_record))
    after, slider = page.locator("img.after:visible"), page.locator(".cut:visible input")
    clip = "(e) => getComputedStyle(e).clipPath"
    begun = slider.input_value(), after.evaluate(clip)
    slider.fill("30")
    assert begun == ("0", "inset(0px 100% 0px 0px)") and after.evaluate(clip) == "inset(0px 70% 0px 0px)"
    slider.press("ArrowRight")  # moves the slider, and does not turn the step
    assert page.locator("section.step").nth(0).is_visible()


def test_the_evidence_column_is_in_sight(open_page, photographed):
    for width in (1300, 400):
        page = open_page(show_page(*photographed))
        page.set_viewport_size({"width": width, "height": 900})
        page.evaluate(UNFOLD)
        settle(page)
        edge = page.locator("td.evidence").first.bounding_box()
        assert edge["x"] + edge["width"] <= width


def test_no_order_and_dark_colours(open_page, browser, stack):
    scene, relations, _ = stack
    page = open_page(show_page(scene, relations, None))
    light = pixels(page)
    page.emulate_media(color_scheme="dark")
    assert pixels(page) != light


def test_the_time_line_moves_the_arm_and_what_it_carries(open_page, run_record):
    page = open_page(run_page(run_record))
    slider, output = page.locator(".player input").first, page.locator(".player output").first
    assert output.inner_text().startswith("approach, 0.0 of")
    begun = pixels(page)
    slider.fill("2.7")
    assert output.inner_text().startswith("lift")
    moved = page.evaluate("() => [...window.panels[0].viewer.moved.keys()]")
    assert [run_record.steps[0].scene.names[number] for number in moved] == [run_record.steps[0].object]
    lifted = pixels(page)
    assert lifted != begun
    slider.focus()
    page.keyboard.press("ArrowLeft")  # scrubs, and does not turn the step
    assert page.locator("section.step").nth(0).is_visible() and pixels(page) != lifted
    page.keyboard.press("Home")
    assert pixels(page) == begun
    page.locator("[data-show=arm]").first.uncheck()
    assert pixels(page) != begun


def test_the_motion_plays_to_its_end_and_stops(open_page, run_record):
    page = open_page(run_page(run_record))
    page.locator(".player input").first.fill("3.3")
    page.locator("[data-play]").first.click()
    page.wait_for_function("() => !window.panels[0].player.playing && window.panels[0].player.time > 3.5")
    assert page.locator("[data-play]").first.inner_text() == "play"


def test_the_marks_of_a_plan_take_the_time_line_there(open_page, lone_plan):
    page = open_page(plan_page(*lone_plan))
    page.locator(".player input").fill("4")
    assert page.locator("[data-time]").first.get_attribute("aria-current") == "step"
    page.locator("[data-time]").first.click()
    assert page.locator(".player output").inner_text().startswith("1. box: move, 0.0 of")


def test_a_printed_run_has_every_step_with_its_view(open_page, run_record):
    page = open_page(run_page(run_record))
    page.emulate_media(media="print")
    page.evaluate("() => window.dispatchEvent(new Event('beforeprint'))")
    sections = page.locator("section.step")
    assert sections.count() == 3 and all(section.is_visible() for section in sections.all())
    assert not page.locator(".player").first.is_visible()
    drawn = page.evaluate(f"() => [...document.querySelectorAll('canvas')].map({PAINTED})")
    assert min(drawn) > 0.2
    page.evaluate("() => window.dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    assert [section.is_visible() for section in sections.all()] == [True, False, False]
