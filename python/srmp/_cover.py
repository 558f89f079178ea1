"""What `srmp cover` says, writes and draws of a RobotCover."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

import srmp
from srmp._files import write_json
from srmp._table import format_seconds, format_table
from srmp._urdf import link_poses_at_zero
from srmp.plot import draw_spheres


def format_report(cover: srmp.RobotCover, coarse_accuracy: float) -> str:
    """A table of the links and one line on time; says when coarse spheres had to grow beyond `coarse_accuracy` [mm]."""
    header = ["link", "coarse", "largest [mm]", "mean [mm]", "fine", "largest [mm]", "mean [mm]", "inner"]
    rows = [
        _row(
            link.link,
            (len(link.coarse), link.coarse_inflation, link.mean_coarse_inflation),
            (len(link.fine), link.fine_inflation, link.mean_fine_inflation),
            len(link.inner),
        )
        for link in cover.links
    ]
    if not rows:
        return "no link has collision geometry"
    totals = statistics(cover)
    coarse, fine = totals["coarse"], totals["fine"]
    rows.append(_row("all", coarse.values(), fine.values(), totals["inner"]["spheres"]))
    lines = [format_table(header, rows, rule_before_last=True)]
    if coarse["max_inflation"] > 1.001e-3 * coarse_accuracy and coarse["max_inflation"] > 1.001 * fine["max_inflation"]:
        lines.append(
            f"coarse spheres grew beyond {coarse_accuracy:g} mm to be so few; --max-spheres allows more of them"
        )
    verb = "read from the cache" if cover.from_cache else "built"
    lines.append(f"{verb} in {format_seconds(cover.seconds)}")
    return "\n".join(lines)


def _row(name: str, coarse: Iterable[float], fine: Iterable[float], inner: float) -> list[str]:
    """Levels are (spheres, largest inflation, mean inflation)."""
    cells = [name]
    for spheres, largest, mean in (coarse, fine):
        cells += [str(spheres), _millimetres(largest), _millimetres(mean)]
    return [*cells, str(inner)]


def _millimetres(metres: float) -> str:
    return f"{1e3 * metres:.1f}"


def statistics(cover: srmp.RobotCover) -> dict[str, dict[str, float]]:
    """Spheres, largest and mean inflation [m] of each level over all links."""

    def level(name: str) -> dict[str, float]:
        counts = [len(getattr(link, name)) for link in cover.links]
        means = [getattr(link, f"mean_{name}_inflation") for link in cover.links]
        return {
            "spheres": sum(counts),
            "max_inflation": max((getattr(link, f"{name}_inflation") for link in cover.links), default=0.0),
            "mean_inflation": float(np.dot(counts, means)) / max(1, sum(counts)),
        }

    return {
        "coarse": level("coarse"),
        "fine": level("fine"),
        "inner": {"spheres": sum(len(link.inner) for link in cover.links)},
    }


def write(cover: srmp.RobotCover, path: str | Path) -> None:
    """JSON: each link's spheres as rows x, y, z, radius [m] in its frame, and the fine ones of each coarse one."""
    links = {
        link.link: {
            "coarse": link.coarse,
            "fine": link.fine,
            "children": link.children,
            "inner": link.inner,
            "coarse_inflation": link.coarse_inflation,
            "fine_inflation": link.fine_inflation,
        }
        for link in cover.links
    }
    write_json(path, {"format": "srmp-cover-1", "statistics": statistics(cover), "links": links})


def draw(cover: srmp.RobotCover, urdf_path: str | Path, path: str | Path) -> None:
    """The two levels side by side, a colour a link, all joints at 0."""
    poses = link_poses_at_zero(urdf_path)

    def placed(link: str, spheres: np.ndarray) -> np.ndarray:
        pose = poses.get(link, np.eye(4))
        return np.column_stack([spheres[:, :3] @ pose[:3, :3].T + pose[:3, 3], spheres[:, 3]])

    totals = statistics(cover)

    def panel(level: str) -> tuple[str, list[np.ndarray]]:
        largest = _millimetres(totals[level]["max_inflation"])
        title = f"{totals[level]['spheres']} {level} spheres, at most {largest} mm outside"
        return title, [placed(link.link, getattr(link, level)) for link in cover.links]

    draw_spheres(path, [panel("coarse"), panel("fine")])
