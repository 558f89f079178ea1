"""Is the answer of a plan the one it was before, bit for bit?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import srmp


def first_difference(before: srmp.PlanResult, now: srmp.PlanResult) -> str | None:
    """Where the two differ first, as a sentence; None: nowhere."""
    if before.status != now.status:
        return f"the status was {before.status.name} and is {now.status.name}{f' ({now.reason})' if now.reason else ''}"
    if not before.solved:
        return None
    if before.trajectory.joint_names != now.trajectory.joint_names:
        return f"the joints were {before.trajectory.joint_names} and are {now.trajectory.joint_names}"
    for name in ("waypoints", "times", "positions", "velocities", "accelerations"):
        a, b = getattr(before.trajectory, name), getattr(now.trajectory, name)
        if len(a) != len(b):
            return f"{name} had {len(a)} rows and has {len(b)}"
        places = np.argwhere(np.ascontiguousarray(a).view(np.uint64) != np.ascontiguousarray(b).view(np.uint64))
        if len(places):
            place = tuple(places[0])
            column = f", column {place[1]} ({before.trajectory.joint_names[place[1]]})" if len(place) > 1 else ""
            return f"{name}, row {place[0]}{column}: was {float(a[place])!r} and is {float(b[place])!r}"
    return None
