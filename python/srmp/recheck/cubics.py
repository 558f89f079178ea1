"""Evaluates timed trajectories between their rows without srmp: the cubics through positions and velocities."""

from __future__ import annotations

import numpy as np


def states(times: np.ndarray, q: np.ndarray, v: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, ...]:
    """Positions, velocities and accelerations (k, dof) at the times `at` (k,) [s], in Bernstein's form."""
    row = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    h = np.diff(times)[row][:, None]
    u = (at - times[row])[:, None] / h
    points = np.array([q[row], q[row] + v[row] * h / 3, q[row + 1] - v[row + 1] * h / 3, q[row + 1]])
    velocities, w = 3 * np.diff(points, axis=0) / h, 1 - u
    accelerations = 2 * np.diff(velocities, axis=0) / h
    return (
        w**3 * points[0] + 3 * w**2 * u * points[1] + 3 * w * u**2 * points[2] + u**3 * points[3],
        w**2 * velocities[0] + 2 * w * u * velocities[1] + u**2 * velocities[2],
        w * accelerations[0] + u * accelerations[1],
    )


def instants(first: float, last: float, rate: float) -> np.ndarray:
    """Instants from `first` to `last` [s], `rate` per second, with `last` itself."""
    return np.append(np.arange(first, last, 1 / rate), last)
