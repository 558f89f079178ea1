"""Takes docs/viewer.png, docs/motion-page.png and docs/constraint-tree.png with Chromium.

    python bench/figures/viewer.py [DIRECTORY]

Needs Debian's packages chromium and chromium-driver, and the Python packages selenium, viser and pillow.
"""

import io
import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image
from selenium import webdriver

import srmp
from srmp.demo import run

COLOURS = 160  # of the files, which keeps them small


def open_browser(width, height):
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    software = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
    for argument in ("--headless=new", "--no-sandbox", *software, f"--window-size={width},{height}"):
        options.add_argument(argument)
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))


def take(browser, path):
    picture = Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB")
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def wait_for(browser):
    """Until the viewer is drawn; its hint at software rendering is hidden."""
    time.sleep(20)
    hint = browser.find_element("xpath", "//*[text()='Software WebGL rendering detected']/../..")
    browser.execute_script("arguments[0].style.display = 'none'", hint)


def take_constraint_tree(browser, path):
    """Two arms face to face reach over each other's side; the conflict at the root of their constraint tree."""
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
        wait_for(browser)
        viewer.show_search(trace)
        viewer.show_conflict(0)
        for title in ("Plan", "Motion", "Robots as", "Limits and clearance"):  # folded away: the tree is below them
            folder = browser.find_element("xpath", f"//p[normalize-space()='{title}'] | //div[text()='{title}']")
            browser.execute_script("arguments[0].click()", folder)
        time.sleep(6)
        take(browser, path)


if __name__ == "__main__":
    directory = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2] / "docs"
    planner = run().planner
    trajectory = planner.last_result.trajectory
    browser = open_browser(1250, 900)
    with planner.show(port=0, open_browser=False) as viewer:
        browser.get(viewer.url)
        wait_for(browser)
        end = planner.compute_fk("arm7", trajectory.positions[-1])
        viewer.set_goal("arm7", srmp.Pose(np.add(end.p, [-0.04, 0.36, -0.09]), end.q))
        time.sleep(4)
        take(browser, directory / "viewer.png")
    take_constraint_tree(browser, directory / "constraint-tree.png")
    with tempfile.TemporaryDirectory() as scratch:
        planner.to_html(Path(scratch) / "motion.html", title="srmp demo")
        browser.set_window_size(1000, 900)
        browser.get(f"file://{scratch}/motion.html")
        time.sleep(3)
        browser.execute_script(f"srmpPlayer.time = {0.65 * trajectory.duration}; srmpPlayer.redraw()")
        time.sleep(1)
        take(browser, directory / "motion-page.png")
    browser.quit()
