"""The viewer and its pages in a real browser: Chromium, headless, with WebGL by software."""

import io
import shutil
import time

import numpy as np
import pytest

import srmp

webdriver = pytest.importorskip("selenium.webdriver", reason="browsers are driven by the package selenium")
ActionBuilder = pytest.importorskip("selenium.webdriver.common.actions.action_builder").ActionBuilder
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if not (CHROMIUM and DRIVER):
    pytest.skip("there is no Chromium with chromedriver on this machine", allow_module_level=True)
image = pytest.importorskip("PIL.Image")

SIZE = (1000, 760)
ORANGE = (0.93, 0.55, 0.20)
RED = (0.86, 0.12, 0.12)


@pytest.fixture(scope="module")
def browser():
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in (
        "--headless=new",
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        f"--window-size={SIZE[0]},{SIZE[1]}",
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    yield driver
    driver.quit()


def world():
    planner = srmp.PlannerInterface()
    planner.add_articulation(
        srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf"), name="arm", end_effector="arm7_hand"
    )
    planner.set_qpos("arm", planner.get_group_states("arm")["ready"])
    planner.add_box("post", [0.1, 0.1, 0.8], srmp.Pose(p=[0.35, 0.35, 0.4]))
    return planner


def pixels(browser):
    """(height, width, 3), 0 to 1, without the panel at the right."""
    shot = image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
    return np.asarray(shot, dtype=float)[:, :640] / 255


def of_colour(picture, colour):
    """Pixels of this hue, lit or in the shade."""
    unit = np.asarray(colour) / np.linalg.norm(colour)
    norms = np.linalg.norm(picture, axis=2)
    return (picture @ unit > 0.985 * norms) & (norms > 0.3) & (np.ptp(picture, axis=2) > 0.25)


def eventually(condition, seconds=20):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.1)


def errors(browser):
    return [entry["message"] for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]


# --- pages that play without a server


@pytest.fixture
def motion_page(browser, tmp_path):
    planner = world()
    q = planner.get_qpos("arm")
    planner.plan("arm", q, q - [0.8, 0, 0, 0, 0, 0, 0])
    planner.to_html(tmp_path / "motion.html")
    browser.get(f"file://{tmp_path / 'motion.html'}")
    eventually(lambda: browser.execute_script("return !!window.srmpPlayer"))
    return browser


def test_a_page_plays_from_a_file(motion_page):
    before = pixels(motion_page)
    assert of_colour(before, ORANGE).sum() > 1500  # the robot is there
    motion_page.find_element("id", "play").click()
    eventually(lambda: motion_page.execute_script("return srmpPlayer.time > 0.5"))
    eventually(lambda: not motion_page.execute_script("return srmpPlayer.playing"))
    after = pixels(motion_page)
    assert (of_colour(before, ORANGE) ^ of_colour(after, ORANGE)).sum() > 500  # and elsewhere at the end
    assert not errors(motion_page)


def test_a_page_is_turned_and_scrubbed(motion_page):
    before = pixels(motion_page)
    canvas = motion_page.find_element("id", "scene")
    webdriver.ActionChains(motion_page).drag_and_drop_by_offset(canvas, 120, 30).perform()
    turned = pixels(motion_page)
    assert (np.abs(turned - before).max(axis=2) > 0.1).mean() > 0.02
    motion_page.execute_script(
        "const t = document.getElementById('time'); t.value = 1; t.dispatchEvent(new Event('input'))"
    )
    assert motion_page.execute_script("return srmpPlayer.time") > 0.5
    assert (np.abs(pixels(motion_page) - turned).max(axis=2) > 0.1).mean() > 0.005


def test_a_page_draws_why_a_plan_failed(browser, tmp_path):
    planner = world()
    with pytest.raises(srmp.PlanningError):
        planner.plan("arm", planner.get_qpos("arm"), srmp.Pose(p=[0.35, 0.35, 0.4], q=[0, 1, 0, 0]))
    planner.to_html(tmp_path / "failed.html")
    browser.get(f"file://{tmp_path / 'failed.html'}")
    eventually(lambda: browser.find_elements("class name", "label"))
    assert "goal_invalid" in browser.find_element("id", "title").text
    assert "post" in browser.find_element("class name", "label").text
    assert of_colour(pixels(browser), RED).sum() > 300


# --- the viewer


@pytest.fixture
def viewer(browser):
    pytest.importorskip("viser", reason="the viewer needs viser: pip install '.[viewer]'")
    planner = world()
    with planner.show(port=0, open_browser=False) as viewer:
        browser.get(viewer.url)
        eventually(lambda: of_colour(pixels(browser), ORANGE).sum() > 1500, 40)
        time.sleep(1)  # the light is faded in
        yield planner, viewer
        browser.get("about:blank")


def press(browser, text):
    button = next(b for b in browser.find_elements("tag name", "button") if b.text == text)
    browser.execute_script("arguments[0].click()", button)


def screen_place(viewer, point):
    """Where a point in the world is in the browser's window, by the camera of its only client."""
    (client,) = viewer._server.get_clients().values()
    back = np.asarray(client.camera.position) - client.camera.look_at
    back /= np.linalg.norm(back)
    right = np.cross([0, 0, 1], back)
    right /= np.linalg.norm(right)
    to_point = np.asarray(point) - client.camera.position
    depth = -to_point @ back
    scale = client.camera.image_height / 2 / np.tan(client.camera.fov / 2) / depth
    up = np.cross(back, right)
    return (
        round(client.camera.image_width / 2 + scale * (to_point @ right)),
        round(client.camera.image_height / 2 - scale * (to_point @ up)),
    )


def test_a_handle_is_dragged_and_a_motion_is_planned_and_played(browser, viewer):
    planner, viewer = viewer
    hand = np.asarray(viewer._handles["arm"].position)
    up = srmp.Pose.from_wxyz(hand, viewer._handles["arm"].wxyz).matrix()[:3, 2]
    x, y = screen_place(viewer, hand + 0.2 * up)  # the arrow along the handle's own z
    x2, y2 = screen_place(viewer, hand + 0.1 * up)
    mouse = ActionBuilder(browser)
    mouse.pointer_action.move_to_location(x, y).pause(0.3).pointer_down().pause(0.2)
    for k in range(1, 6):
        mouse.pointer_action.move_to_location(x + (x2 - x) * k // 5, y + (y2 - y) * k // 5).pause(0.1)
    mouse.pointer_action.pointer_up()
    mouse.perform()
    eventually(lambda: "arm" in viewer.goals)
    eventually(lambda: not viewer._dragged and viewer._jobs.empty())
    goal = np.asarray(viewer.goals["arm"].p)
    assert 0.02 < np.linalg.norm(goal - hand) < 0.3
    before = of_colour(pixels(browser), ORANGE)
    press(browser, "Plan")
    eventually(lambda: viewer.status.startswith("solved in"))
    eventually(lambda: not viewer._playing)
    end = viewer.trajectory["arm"].positions[-1]
    assert np.allclose(planner.compute_fk("arm", end).p, goal, atol=1e-3)
    eventually(lambda: (before ^ of_colour(pixels(browser), ORANGE)).sum() > 300)


def test_an_object_of_the_program_appears(browser, viewer):
    planner, viewer = viewer
    before = pixels(browser)
    planner.add_sphere("ball", 0.15, srmp.Pose(p=[0, 0.5, 0.5]))
    eventually(lambda: (np.abs(pixels(browser) - before).max(axis=2) > 0.15).sum() > 1500)
    planner.remove_object("ball")
    eventually(lambda: (np.abs(pixels(browser) - before).max(axis=2) > 0.15).sum() < 200)


def test_a_failure_is_drawn(browser, viewer):
    planner, viewer = viewer
    with pytest.raises(srmp.PlanningError):
        planner.plan("arm", planner.get_qpos("arm"), srmp.Pose(p=[0.35, 0.35, 0.4], q=[0, 1, 0, 0]))
    eventually(lambda: of_colour(pixels(browser), RED).sum() > 300)
    eventually(lambda: "goal_invalid" in browser.find_element("tag name", "body").text)
    assert "post" in browser.find_element("tag name", "body").text
