"""The content of a plan file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import srmp


def plan_result(
    stats: Mapping[str, Any], joint_names: Sequence[str], trajectory: srmp.Trajectory | None
) -> dict[str, Any]:
    """Status, statistics and, when solved, path, timed trajectory and certificate; rows in the order of joint_names."""
    import srmp

    result: dict[str, Any] = {
        "srmp_version": srmp.__version__,
        "status": getattr(stats["status"], "name", stats["status"]),
        "reason": stats["reason"],
        "joint_names": list(joint_names),
        "statistics": {key: value for key, value in stats.items() if key not in ("status", "reason")},
    }
    if trajectory is not None:
        result["path"] = trajectory.waypoints
        for key in ("times", "positions", "velocities", "accelerations"):
            result[key] = getattr(trajectory, key)
        if trajectory.certificate is not None:
            result["certificate"] = trajectory.certificate.to_dict()
    return result
