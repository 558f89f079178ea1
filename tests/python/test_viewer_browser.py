"""The viewer and its pages in a real browser: Chromium, headless, with WebGL by software."""

import io
import shutil
import time

import numpy as np
import pytest
from support import eventually

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


def errors(browser):
    return [entry["message"] for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]


COUNT_UPDATES = """
window.updates = 0;  // batches of messages that move something, as the page's own thread gets them
const Native = window.Worker;
window.Worker = class extends Native {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => {
      if ((data.messages || []).some((message) => message.type === "SetPositionMessage")) updates++;
    });
  }
};
"""


def four_arms():
    """Four arms that swing for 30 s."""
    planner = srmp.PlannerInterface()
    motions = {}
    for k, name in enumerate("abcd"):
        planner.add_robot("arm7", name=name, base_pose=srmp.Pose(p=[0, 1.1 * k, 0]))
        q = planner.get_group_states(name)["ready"]
        planner.set_qpos(name, q)
        rows = [q, q - 0.4, q + 0.4, q, q - 0.4, q + 0.4, q]
        motions[name] = srmp.Trajectory(planner.get_joint_names(name), rows, 5 * np.arange(7))
    return planner, motions


def rate(browser, counter, seconds=3):
    """How often a counter of the page counts in a second of the page's clock."""
    script = f"return [performance.now() / 1000, {counter}]"
    begin, before = browser.execute_script(script)
    time.sleep(seconds)
    end, after = browser.execute_script(script)
    return (after - before) / (end - begin)


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


def test_a_page_of_four_arms_plays(browser, tmp_path, record_property):
    """How many frames a second it draws is recorded, not required: that depends on the machine."""
    planner, motions = four_arms()
    planner.to_html(tmp_path / "four.html", motions)
    browser.get(f"file://{tmp_path / 'four.html'}")
    eventually(lambda: browser.execute_script("return !!window.srmpPlayer"))
    browser.execute_script(
        "window.frames_ = 0; const draw = srmpPlayer.picture.draw.bind(srmpPlayer.picture);"
        "srmpPlayer.picture.draw = (...given) => { frames_++; return draw(...given); }"
    )
    browser.find_element("id", "play").click()
    frames = rate(browser, "frames_")
    record_property("frames a second", frames)
    print(f"four arms in a page: {frames:.1f} frames a second")
    assert frames > 0 and browser.execute_script("return srmpPlayer.time > 0")


def test_a_page_has_its_certificate(motion_page):
    (panel,) = motion_page.find_elements("css selector", "#panels details")
    assert panel.text == "certificate of 'arm'"
    panel.find_element("tag name", "summary").click()
    assert "proved at least" in panel.text and "% of the limit" in panel.text


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


def test_updates_of_four_arms_arrive(browser, record_property):
    """How many a second is recorded, not required: that depends on the machine."""
    pytest.importorskip("viser", reason="the viewer needs viser: pip install '.[viewer]'")
    script = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": COUNT_UPDATES})
    planner, motions = four_arms()
    with planner.show(motions, port=0, open_browser=False) as viewer:
        browser.get(viewer.url)
        eventually(lambda: browser.execute_script("return updates > 0"), 40)
        viewer.play()
        updates = rate(browser, "updates")
        browser.get("about:blank")
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
    record_property("updates a second", updates)
    print(f"four arms in the viewer: {updates:.1f} updates a second")
    assert updates > 0


def test_a_constraint_tree_is_drawn(browser):
    pytest.importorskip("viser", reason="the viewer needs viser: pip install '.[viewer]'")
    planner = srmp.PlannerInterface()
    for name, x, yaw in (("left", 0.0, 0.0), ("right", 0.8, np.pi)):
        planner.add_robot("arm7", name=name, base_pose=srmp.Pose.from_rpy([x, 0, 0], [0, 0, yaw]))
    planner.make_planner(["left", "right"], srmp.ECBS())
    over = [srmp.Pose.from_rpy([0.4, y, 0.2], [np.pi, 0, 0]) for y in (0.2, -0.2)]
    ready = planner.get_group_states("left")["ready"]
    starts = {name: planner.compute_ik(name, over[k], ready)[0] for k, name in enumerate(("left", "right"))}
    with srmp.SearchTrace() as trace:
        planner.plan_multi(starts, {"left": over[1], "right": over[0]})
    with planner.show(port=0, open_browser=False) as viewer:
        browser.get(viewer.url)
        eventually(lambda: (np.ptp(pixels(browser), axis=2) > 0.25).sum() > 1500, 40)
        viewer.on_seek(0.5 * viewer._motion.duration)
        time.sleep(1)
        before = pixels(browser)
        viewer.show_search(trace)
        viewer.show_conflict(0)
        eventually(lambda: (np.abs(pixels(browser) - before).max(axis=2) > 0.15).sum() > 500, 40)
        eventually(
            lambda: len(browser.find_elements("css selector", "svg circle title")) == len(trace.constraint_nodes)
        )
        browser.get("about:blank")
