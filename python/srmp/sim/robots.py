"""Which robot of the planner is which articulation of a simulator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from srmp import InvalidArgument, PlannerInterface
from srmp._names import did_you_mean
from srmp.sim.simulator import Articulation


@dataclass
class Robot:
    """A robot of the planner and the articulation that it is in the simulator."""

    name: str
    articulation: str
    joints: dict[str, str]  # all movable joints of the planner's robot that the simulator has, to its name there
    links: dict[str, str]  # the same for links
    from_simulator: bool  # made of the simulator's own model
    differences: list[str] = field(default_factory=list)  # between URDF and simulator, as sentences
    merged: dict[str, str] = field(default_factory=dict)  # links that are part of another in the simulator, to that


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Names without the "prefix/" that all of them share."""
    full = list(names)
    prefixes = {name.rpartition("/")[0] for name in full}
    cut = len(prefixes.pop()) + 1 if len(prefixes) == 1 and "" not in prefixes else 0
    return {name: name[cut:] for name in full}


def only_end(robot: str, articulation: Articulation, links: Mapping[str, str]) -> str:
    """The only leaf link of the articulation, by the planner's name. Raises InvalidArgument where there are several."""
    parents = {joint.parent for joint in articulation.joints}
    ends = [links[link.name] for link in articulation.links if link.name not in parents]
    if len(ends) > 1:
        raise InvalidArgument(
            f"robot '{robot}' has {len(ends)} links at its ends ({', '.join(ends)}); say which one goals refer to: "
            f"articulations={{'{robot}': {{'end_effector': …}}}}"
        )
    return ends[0]


def match_robot(
    planner: PlannerInterface, name: str, articulation: Articulation, bodies: list[str], own: bool
) -> Robot:
    """Which joints and links of the planner's robot are which in the simulator.

    bodies: the articulation's links without those that only stand between two joints of one body.
    """
    movable = {joint.name: joint for joint in articulation.joints if joint.kind != "fixed"}
    in_planner = list(planner.get_all_joint_limits(name))
    joints = _pair(in_planner, list(movable))
    for joint in planner.get_joint_names(name):
        if joint not in joints:
            raise InvalidArgument(
                f"robot '{name}' has a joint '{joint}', articulation '{articulation.name}' has none of that name"
                + (did_you_mean(joint, movable, before="; ") or f"; its joints: {', '.join(movable) or 'none'}")
            )
    in_links = planner.get_link_names(name)
    links = _pair(in_links, bodies)
    if not links:
        raise InvalidArgument(
            f"robot '{name}' and articulation '{articulation.name}' have no link name in common; it has "
            f"{', '.join(bodies)}"
        )
    merged = {} if own else _merged(planner, name, links)
    lists = [
        *(
            (
                f"link of robot '{name}' is part of link '{whole}' in the simulator",
                [x for x in merged if merged[x] == whole],
            )
            for whole in dict.fromkeys(merged.values())
        ),
        (
            f"link of robot '{name}' has no counterpart in the simulator",
            [x for x in in_links if x not in links and x not in merged and not own],
        ),
        (f"joint of robot '{name}' has no counterpart in the simulator", [x for x in in_planner if x not in joints]),
        (
            f"link of articulation '{articulation.name}' has no counterpart in the URDF",
            [body for body in bodies if body not in links.values()],
        ),
        (
            f"joint of articulation '{articulation.name}' has no counterpart in the URDF",
            [joint for joint in movable if joint not in joints.values()],
        ),
    ]
    differences = [f"{what}: {', '.join(names)}" for what, names in lists if names]
    return Robot(name, articulation.name, joints, links, own, differences, merged)


def _merged(planner: PlannerInterface, robot: str, links: Mapping[str, str]) -> dict[str, str]:
    """Links that the simulator does not have, but which never move against one that it has: to that one."""
    limits = planner.get_joint_limits(robot)[:, :2]
    lower, upper = np.maximum(limits[:, 0], -1.0), np.minimum(limits[:, 1], 1.0)
    states = [lower + fraction * (upper - lower) for fraction in (0.2, 0.7)]

    def stands_still(link: str, other: str) -> bool:
        a, b = (
            planner.compute_fk(robot, q, link).inverse().matrix() @ planner.compute_fk(robot, q, other).matrix()
            for q in states
        )
        return np.allclose(a, b, atol=1e-9)

    found: dict[str, str] = {}
    above: list[str] = []  # links that both have, so far
    for link in planner.get_link_names(robot):
        if link in links:
            above.append(link)
            continue
        below = [other for other in links if other not in above]
        whole = next((other for other in [*reversed(above), *below] if stands_still(link, other)), None)
        if whole is not None:
            found[link] = links[whole]
    return found


def _pair(ours: Sequence[str], theirs: Sequence[str]) -> dict[str, str]:
    """Equal names; where there is none, the only one that ends with "/name"."""
    pairs = {}
    for name in ours:
        endings = [other for other in theirs if other.endswith(f"/{name}")]
        if name in theirs:
            pairs[name] = name
        elif len(endings) == 1:
            pairs[name] = endings[0]
    return pairs


def require_known(what: str, name: str, known: Mapping[str, Any]) -> Any:
    """The value of `name` in `known`. Raises InvalidArgument with the nearest name where there is none."""
    if not isinstance(name, str) or name not in known:
        raise InvalidArgument(
            f"unknown {what} {name!r}"
            + (did_you_mean(name, known, before="; ") or f"; known: {', '.join(known) or 'none'}")
        )
    return known[name]
