"""Takes docs/viewer.png and docs/motion-page.png with Chromium.

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


if __name__ == "__main__":
    directory = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2] / "docs"
    planner = run().planner
    trajectory = planner.last_result.trajectory
    browser = open_browser(1250, 900)
    with planner.show(port=0, open_browser=False) as viewer:
        browser.get(viewer.url)
        time.sleep(20)
        hint = browser.find_element("xpath", "//*[text()='Software WebGL rendering detected']/../..")
        browser.execute_script("arguments[0].style.display = 'none'", hint)
        end = planner.compute_fk("arm7", trajectory.positions[-1])
        viewer.set_goal("arm7", srmp.Pose(np.add(end.p, [-0.04, 0.36, -0.09]), end.q))
        time.sleep(4)
        take(browser, directory / "viewer.png")
    with tempfile.TemporaryDirectory() as scratch:
        planner.to_html(Path(scratch) / "motion.html", title="srmp demo")
        browser.set_window_size(1000, 900)
        browser.get(f"file://{scratch}/motion.html")
        time.sleep(3)
        browser.execute_script(f"srmpPlayer.time = {0.65 * trajectory.duration}; srmpPlayer.redraw()")
        time.sleep(1)
        take(browser, directory / "motion-page.png")
    browser.quit()
