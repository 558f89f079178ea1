"""Makes docs/robots.png, a contact sheet of all robots that `srmp robots` lists and that can be drawn.

    python bench/figures/robots.py [PNG]

Needs the packages example-robot-data, pybullet, trimesh, pycollada and pillow. The pictures are those of
`srmp robots --pictures`.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageChops, ImageDraw

COLUMNS, CELL, TEXT = 9, 140, 14  # [px]
COLOURS = 64  # of the file, which keeps it small


def cut_out(path):
    """The picture without its margins and title."""
    picture = Image.open(path).convert("RGB")
    picture = picture.crop((0, picture.height // 16, picture.width, picture.height))
    box = ImageChops.difference(picture, Image.new("RGB", picture.size, "white")).getbbox()
    picture = picture.crop(box)
    picture.thumbnail((CELL - 8, CELL - 8))
    return picture


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[2] / "docs" / "robots.png"
    with tempfile.TemporaryDirectory() as scratch:
        subprocess.run([sys.executable, "-m", "srmp", "robots", "--pictures", scratch], check=True)
        paths = sorted(Path(scratch).glob("*.png"))
        rows = -(-len(paths) // COLUMNS)
        sheet = Image.new("RGB", (COLUMNS * CELL, rows * (CELL + TEXT)), "white")
        draw = ImageDraw.Draw(sheet)
        for k, path in enumerate(paths):
            x, y = k % COLUMNS * CELL, k // COLUMNS * (CELL + TEXT)
            picture = cut_out(path)
            sheet.paste(picture, (x + (CELL - picture.width) // 2, y + (CELL - picture.height) // 2))
            draw.text((x + CELL // 2, y + CELL), path.stem, fill="#26303a", anchor="mt", font_size=10)
    sheet.quantize(COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)
    print(f"{len(paths)} robots, {target.stat().st_size / 1e3:.0f} kB")
