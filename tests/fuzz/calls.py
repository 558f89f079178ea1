"""Sequences of API calls with arguments that nobody would give, the same on every machine.

A call may raise srmp.Error, or TypeError for what no signature has; it must not crash, take longer than 5 s, more than
2 GB, or raise anything else.

    python tests/fuzz/calls.py [--cases N] [--from K] [--minutes M] [--show]
"""

import argparse
import faulthandler
import os
import random
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

import srmp

MAX_SECONDS, MAX_ADDRESSES = 5, 4 << 30  # 2 GB of data, and the program with its libraries
LIMIT = "<limit lower='-3' upper='3' velocity='2' effort='1'/>"


def bar(name):
    return (
        f"<link name='{name}'><collision><origin xyz='0.25 0 0'/><geometry><box size='0.4 0.05 0.05'/></geometry>"
        "</collision></link>"
    )


def joint(name, parent, child, x):
    return (
        f"<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>"
        f"<origin xyz='{x} 0 0'/><axis xyz='0 0 1'/>{LIMIT}</joint>"
    )


URDF = (
    f"<robot name='planar'><link name='base'/>{bar('upper')}{bar('lower')}"
    f"{joint('a', 'base', 'upper', 0)}{joint('b', 'upper', 'lower', 0.5)}</robot>"
)
NUMBERS = [0, 1, -1, 0.1, 0.5, 2, 1e-300, 1e-160, 1e-9, 1e3, 1e4, 1e20, 1e160, 1e308, float("nan"), float("inf"), 2**70]
WORDS = ["", "arm", "box", "lower", "arm/lower", "a", "no", "\0", "\udc80", "\n", "x" * 2000, "桌子", "..", "auto"]


class Nasty:
    """An object whose every conversion fails."""

    def fail(self, *_):
        raise TypeError("nasty")

    __array__ = __float__ = __len__ = __iter__ = __fspath__ = fail


class Maker:
    """Makes arguments: mostly valid ones."""

    def __init__(self, seed, directory):
        self.random = random.Random(seed)
        self.directory = directory

    def number(self):
        return self.random.choice(NUMBERS) if self.random.random() < 0.2 else round(self.random.uniform(-3, 3), 3)

    def length(self):
        return self.random.choice(NUMBERS) if self.random.random() < 0.2 else round(self.random.uniform(0.01, 1), 3)

    def numbers(self, count):
        if self.random.random() < 0.1:
            count = self.random.randrange(5)
        return [self.number() for _ in range(count)]

    def rows(self, count, columns):
        rows = [self.numbers(columns) for _ in range(self.random.randrange(count + 1))]
        return rows if self.random.random() < 0.9 else self.anything()

    def name(self, *known):
        return self.random.choice(known if self.random.random() < 0.8 else WORDS)

    def pose(self):
        return (
            srmp.Pose(p=self.numbers(3)) if self.random.random() < 0.8 else srmp.Pose(self.numbers(3), self.numbers(4))
        )

    def anything(self):
        return self.random.choice(
            [
                None,
                True,
                1,
                1e300,
                "x",
                "\udc80",
                b"\xff",
                [],
                {},
                (),
                [[1], [1, 2]],
                {"a": 1},
                np.zeros((2, 0)),
                Nasty(),
                np.array(["a"]),
                np.array([1j]),
                np.zeros((1, 1, 1)),
                object(),
                srmp.Pose(),
                srmp.GoalConstraint.hold(),
            ]
        )

    def goal(self):
        kind = self.random.randrange(5)
        if kind == 0:
            return srmp.GoalConstraint.hold()
        if kind == 1:
            return srmp.GoalConstraint(srmp.GoalType.POSE, self.pose())
        if kind == 2:
            return srmp.GoalConstraint(srmp.GoalType.POSITION, self.numbers(3))
        return srmp.GoalConstraint(srmp.GoalType.JOINTS, self.numbers(2))

    def options(self):
        options = {"planner_id": self.name("auto", "wAstar", "ARAstar", "RRTConnect"), "time_limit": 0.05}
        for _ in range(self.random.randrange(3)):
            key = self.name("weight", "improve_rounds", "resolution", "time_limit", "sample_period", "certificate")
            options[key] = self.random.choice([self.number(), self.name("true", "1e300"), self.anything()])
        return options

    def path(self):
        return self.random.choice([self.directory / "p.json", self.directory, "", "/nowhere/p", "\0", "\udc80", None])

    def spoil(self, arguments):
        """Sometimes one argument is something else."""
        if arguments and self.random.random() < 0.15:
            arguments = list(arguments)
            arguments[self.random.randrange(len(arguments))] = self.anything()
        return arguments


CALLS = {
    "add_box": lambda m: (m.name("box"), [m.length() for _ in range(3)], m.pose()),
    "add_sphere": lambda m: (m.name("ball"), m.length(), m.pose(), m.length()),
    "add_cylinder": lambda m: (m.name("can"), m.length(), m.length(), m.pose()),
    "add_cone": lambda m: (m.name("cone"), m.length(), m.length(), m.pose()),
    "add_point_cloud": lambda m: (m.name("cloud"), m.rows(5, 3), m.length(), m.pose(), m.length()),
    "add_mesh": lambda m: {"name": m.name("mesh"), "vertices": m.rows(8, 3), "triangles": [[0, 1, 2], [1, 2, 3]]},
    "add_mesh ": lambda m: {"name": m.name("hull"), "vertices": m.rows(8, 3), "convex": True},
    "remove_object": lambda m: (m.name("box", "ball", "mesh", "hull", "cloud"),),
    "set_object_pose": lambda m: (m.name("box", "ball"), m.pose()),
    "set_padding": lambda m: (m.name("box", "arm"), m.length()),
    "attach_object": lambda m: (m.name("box", "ball", "mesh"), m.name("arm"), m.name("lower"), [m.name("upper")]),
    "detach_object": lambda m: (m.name("box", "ball"),),
    "set_allowed_collision": lambda m: (m.name("box", "arm/lower", "upper"), m.name("ball", "arm")),
    "set_qpos": lambda m: (m.name("arm"), m.numbers(2)),
    "set_joint_positions": lambda m: (m.name("arm"), {m.name("a", "b"): m.number()}),
    "set_base_pose": lambda m: (m.name("arm"), m.pose()),
    "compute_fk": lambda m: (m.name("arm"), m.numbers(2), m.name("lower")),
    "compute_jacobian": lambda m: (m.name("arm"), m.numbers(2)),
    "compute_ik": lambda m: (m.name("arm"), m.pose(), m.numbers(2)),
    "is_state_colliding": lambda m: (m.name("arm"), m.numbers(2)),
    "contacts": lambda m: (m.name("arm"), m.numbers(2)),
    "nearest": lambda m: (m.name("arm"), m.numbers(2)),
    "distance_to_collision": lambda m: (m.name("arm"), m.numbers(2)),
    "is_motion_free": lambda m: (m.name("arm"), m.numbers(2), m.numbers(2)),
    "set_motion_limits": lambda m: (m.name("arm"), m.length(), m.length(), m.length()),
    "make_planner": lambda m: (m.name("arm"), m.options()),
    "plan": lambda m: (m.name("arm"), m.numbers(2), m.goal()),
    "plan_multi": lambda m: ({m.name("arm"): m.numbers(2)}, {m.name("arm"): m.goal()}),
    "save": lambda m: (m.path(),),
    "load_scene": lambda m: (m.path(),),
    "load_moveit_scene": lambda m: (m.path(),),
    "remove_articulation": lambda m: (m.name("arm", "second"),),
    "add_articulation": lambda m: {"urdf_text": URDF, "name": m.name("second", "arm"), "base_pose": m.pose()},
    "reset": lambda _: (),
}
READS = ["object_names", "robot_names", "last_request", "last_result"]


def run_case(maker, counts, *, show):
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=URDF, name="arm", end_effector="lower")
    planner.make_planner("arm", {"time_limit": 0.05})
    for _ in range(maker.random.randrange(1, 12)):
        name = maker.random.choice(list(CALLS))
        try:
            arguments = CALLS[name](maker)
            named = arguments if isinstance(arguments, dict) else {}
            rest = () if named else maker.spoil(arguments)
            if show:
                print(name, rest, named)
            getattr(planner, name.strip())(*rest, **named)
            counts["accepted"] += 1
        except srmp.Error as error:
            counts["refused"] += 1
            if len(str(error)) >= 500 or "\n" in str(error):
                raise AssertionError(f"{name}: not one short sentence: {error}") from error
        except TypeError:
            counts["TypeError"] += 1
        for read in READS:
            getattr(planner, read)
    counts["cases"] += 1


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--from", type=int, default=0, dest="first")
    parser.add_argument("--minutes", type=float, default=0)
    parser.add_argument("--show", action="store_true")
    options = parser.parse_args(arguments)
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_AS, (MAX_ADDRESSES, MAX_ADDRESSES))
    warnings.simplefilter("ignore")
    counts, faults, start, case = Counter(), 0, time.monotonic(), options.first
    with tempfile.TemporaryDirectory() as directory:
        os.chdir(directory)  # for files of relative names
        while case < options.first + options.cases or time.monotonic() < start + 60 * options.minutes:
            faulthandler.dump_traceback_later(4 * MAX_SECONDS, exit=True)  # a case is up to twelve calls
            try:
                run_case(Maker(case, Path(directory)), counts, show=options.show)
            except Exception as error:  # whatever it is, it is what this program looks for
                faults += 1
                print(f"FAULT in case {case}: {type(error).__name__}: {str(error)[:300]}", file=sys.stderr)
            case += 1
    faulthandler.cancel_dump_traceback_later()
    print(f"{'calls':16} {dict(counts)} {faults} faults  {time.monotonic() - start:.1f} s")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
