"""How much the solutions of similar problems differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def coefficient_of_variation(lengths: Sequence[float]) -> float:
    """Standard deviation (of the n - 1 kind) by mean; NaN for fewer than two."""
    return float(np.std(lengths, ddof=1) / np.mean(lengths)) if len(lengths) > 1 else math.nan


def variation(rows: Sequence[Mapping[str, Any]]) -> float:
    """Of the summed end-effector lengths over the repetitions of a problem, the mean over problems; NaN: none has two.

    The problem is what `base` says; rows that are not solved do not count.
    """
    lengths: dict[int, list[float]] = {}
    for row in rows:
        if row["status"] == "solved" and "base" in row:
            lengths.setdefault(row["base"], []).append(row["ee_cost_m"])
    ratios = [coefficient_of_variation(some) for some in lengths.values() if len(some) > 1]
    return float(np.mean(ratios)) if ratios else math.nan
