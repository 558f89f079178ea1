"""What several commands say of MoveIt's requests."""

from __future__ import annotations

from pathlib import Path

import srmp


def require_unconstrained(problem: srmp.MoveItProblem, path: str | Path) -> None:
    """Raises NotSupported for a request with path constraints or a max_cartesian_speed, or that begins in motion."""
    for given, what in (
        (bool(problem.constraints), "has path_constraints"),
        (bool(problem.link_speeds), "has a max_cartesian_speed"),
        (problem.start_velocity is not None, "begins in motion"),
    ):
        if given:
            raise srmp.NotSupported(f"{path}: the request {what}, which is not supported here; plan takes it.")
