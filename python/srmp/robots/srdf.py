"""Allowed collisions by sampling, for robots without an SRDF; `srmp srdf` writes them as one."""

from __future__ import annotations

import os
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

import srmp
from srmp._errors import checked
from srmp._files import write_text
from srmp._names import did_you_mean

ALWAYS = 0.95  # of the samples; the fraction that the library itself takes for always
REASONS = ("Adjacent", "Always", "Default", "Never")


@dataclass
class AllowedCollisions:
    """Pairs of links of a robot whose contact is allowed, and why."""

    robot: str  #: the URDF's name
    pairs: dict[tuple[str, str], str]  #: one of REASONS by pair of links, in the order of the URDF
    checked: dict[tuple[str, str], float]  #: the pairs that stay checked: in which fraction of the samples they touch
    samples: int
    seed: int
    chain: tuple[str, str] | None = None  #: first and last link of the planning group
    group: str = ""
    warnings: list[str] = field(default_factory=list)  #: what of the URDF was not used

    def report(self) -> str:
        """How many pairs there are of each reason, and every pair that stays checked and was seen in contact."""
        counts = Counter(self.pairs.values())
        lines = [
            f"{self.robot}: {len(self.pairs) + len(self.checked)} pairs of links, {self.samples} samples, "
            f"seed {self.seed}",
            f"  {counts['Adjacent']:5} adjacent: a joint connects them, or they are one rigid body",
            f"  {counts['Always']:5} always in contact: in more than {ALWAYS:.0%} of the samples",
            f"  {counts['Default']:5} in contact with all joints at 0",
            f"  {counts['Never']:5} never in contact in any sample",
            f"  {len(self.checked):5} stay checked:",
        ]
        often = sorted(self.checked.items(), key=lambda item: (-item[1], item[0]))
        return "\n".join(lines + [f"        {a} – {b}: {fraction:.1%} of the samples" for (a, b), fraction in often])

    def to_srdf(self) -> str:
        """The SRDF as text: disable_collisions with their reasons, and the group where one was asked for."""
        root = ElementTree.Element("robot", name=self.robot)
        root.append(ElementTree.Comment(f" {self.samples} samples, seed {self.seed} "))
        if self.chain:
            group = ElementTree.SubElement(root, "group", name=self.group)
            ElementTree.SubElement(group, "chain", base_link=self.chain[0], tip_link=self.chain[1])
        for (a, b), reason in self.pairs.items():
            ElementTree.SubElement(root, "disable_collisions", link1=a, link2=b, reason=reason)
        ElementTree.indent(root)
        return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"

    @checked
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the SRDF. Raises FileError."""
        write_text(path, self.to_srdf())


@checked
def sample_allowed_collisions(
    urdf_path: str | os.PathLike[str],
    *,
    samples: int = 10_000,
    seed: int = 0,
    end_effector: str = "",
    group: str = "arm",
    package_dirs: Sequence[str] = (),
    progress: Callable[[int, int], None] | None = None,
) -> AllowedCollisions:
    """The pairs of links of a robot whose contact needs no check, found in `samples` random configurations.

    Allowed are pairs that a joint connects, those that always touch, those that touch with all joints at 0, and those
    that touch in no sample. All movable joints are sampled, evenly within their limits, continuous ones in a whole
    turn. The same arguments give the same pairs. With `end_effector`, the SRDF has a planning group, named `group`:
    the chain from the root link to it. progress(done, samples) is called now and then.

    A pair that touches in very few configurations may be taken for one that never does: more samples make that rarer.

    Raises InvalidArgument (samples below 1, seed below 0, a group without a name, a link that does not exist) and
    FileError.
    """
    _require_whole("samples", samples, 1)
    _require_whole("seed", seed, 0)
    if not group:
        raise srmp.InvalidArgument("group is empty; give the planning group a name")
    planner, name, notes = _load(str(urdf_path), list(package_dirs))
    links = planner.get_link_names(name)
    if end_effector and end_effector not in links:
        raise srmp.InvalidArgument(
            f"end_effector: '{name}' has no link '{end_effector}'{did_you_mean(end_effector, links)}"
        )
    limits = np.clip(planner.get_joint_limits(name)[:, :2], -np.pi, np.pi)
    at_zero = _pairs_in_contact(planner, name, np.clip(np.zeros(len(limits)), *limits.T), links)
    random, touched = np.random.default_rng(seed), Counter[tuple[str, str]]()
    for done in range(samples):
        touched.update(_pairs_in_contact(planner, name, random.uniform(*limits.T), links))
        if progress and (done + 1) % 100 == 0:
            progress(done + 1, samples)
    solid = {
        link.get("name") for link in _root_of(str(urdf_path)).findall("link") if link.find("collision") is not None
    }
    bodies = [link for link in links if link in solid]
    pairs, checked = _judge(planner, name, bodies, at_zero, touched, samples)
    chain = (links[0], end_effector) if end_effector else None
    return AllowedCollisions(name, pairs, checked, samples, seed, chain, group if chain else "", notes)


def _require_whole(what: str, value: object, least: int) -> None:
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or value < least:
        raise srmp.InvalidArgument(f"{what} must be a whole number of at least {least}, but is {value!r}")


def _load(urdf: str, package_dirs: list[str]) -> tuple[srmp.PlannerInterface, str, list[str]]:
    """The robot with all its movable joints planned; without SRDF the library allows what is adjacent or constant."""
    planner = srmp.PlannerInterface()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", srmp.RobotWarning)
        root = _root_of(urdf)
        name = root.get("name") or Path(urdf).stem
        moved = _movable_joints(root)
        planner.add_articulation(
            urdf_path=urdf,
            name=name,
            end_effector=moved[-1][1],
            joint_names=[joint for joint, _ in moved],
            package_dirs=package_dirs,
        )
    return planner, name, planner.warnings(name)


def _root_of(urdf: str) -> ElementTree.Element:
    try:
        return ElementTree.parse(urdf).getroot()
    except OSError as error:
        raise srmp.FileError(f"cannot read '{urdf}': {error.strerror or error}") from error
    except (ElementTree.ParseError, ValueError) as error:  # ValueError: a character that no path has
        raise srmp.FileError(f"'{urdf}' is not a URDF: {error}") from error


def _movable_joints(root: ElementTree.Element) -> list[tuple[str, str]]:
    """Names of joints and of the links below them. Those that mimic another are moved by it."""
    joints = [
        (joint.get("name", ""), child.get("link", ""))
        for joint in root.findall("joint")
        if joint.get("type") in ("revolute", "continuous", "prismatic")
        and joint.find("mimic") is None
        and (child := joint.find("child")) is not None
    ]
    if not joints:
        raise srmp.InvalidArgument(
            f"'{root.get('name')}' has no movable joint, so nothing can be sampled; was its Xacro expanded?"
        )
    return joints


def _pairs_in_contact(
    planner: srmp.PlannerInterface, name: str, q: np.ndarray, links: Sequence[str]
) -> set[tuple[str, str]]:
    """In the order of the URDF."""
    pairs = (sorted((contact.body_a, contact.body_b), key=links.index) for contact in planner.contacts(name, q))
    return {(a, b) for a, b in pairs}


def _judge(
    planner: srmp.PlannerInterface,
    name: str,
    bodies: Sequence[str],
    at_zero: set[tuple[str, str]],
    touched: Counter[tuple[str, str]],
    samples: int,
) -> tuple[dict[tuple[str, str], str], dict[tuple[str, str], float]]:
    always = {tuple(sorted(pair, key=bodies.index)) for pair in planner.get_always_colliding(name)}
    pairs: dict[tuple[str, str], str] = {}
    checked: dict[tuple[str, str], float] = {}
    for i, a in enumerate(bodies):
        for b in bodies[i + 1 :]:
            fraction = touched[a, b] / samples
            if (a, b) in always or fraction > ALWAYS:
                pairs[a, b] = "Always"
            elif planner.allowed_collision(f"{name}/{a}", f"{name}/{b}"):
                pairs[a, b] = "Adjacent"
            elif (a, b) in at_zero:
                pairs[a, b] = "Default"
            elif fraction == 0:
                pairs[a, b] = "Never"
            else:
                checked[a, b] = fraction
    return pairs, checked
