"""Calls and files of the Python package with arguments that nobody would give, the same on every machine.

A case may raise srmp.Error, or TypeError for what no signature has; it must not crash, take a call longer than 5 s,
more than 2 GB, or raise anything else. Without arguments: a few seconds of every door. After a crash or a hang, --show
says in which case it was.

    python tests/fuzz/calls.py [DOOR ...] [--cases N] [--from K] [--minutes M] [--show]
"""

import argparse
import faulthandler
import os
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

from arguments import URDF, URDF3, Maker, MotionMaker, changed

import srmp
import srmp.datasets
from srmp.robots._list import read_list

MAX_SECONDS, MAX_ADDRESSES = 5, 4 << 30  # 2 GB of data, and the program with its libraries
SEEDS = Path(__file__).parent / "seeds"

SCENE_CALLS = {
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


def deviations(m):
    return {"max_deviation": m.length() / 10, "max_rotation": m.length() / 2} if m.chance(0.3) else {}


def call_follow(m):
    start = m.numbers(3)
    link, constraints = m.name("", "lower", "middle"), m.constraints()
    return m.planner.follow(m.name("arm"), start, m.near(start), link=link, constraints=constraints, **deviations(m))


def call_plan_linear(m):
    start = m.numbers(3)
    link, constraints = m.name("", "lower"), m.constraints()
    return m.planner.plan_linear(
        m.name("arm"), start, m.near(start)[0], link=link, constraints=constraints, **deviations(m)
    )


def call_plan(m):
    velocity = [x / 5 for x in m.numbers(3)] if m.chance(0.2) else None
    return m.planner.plan("arm", m.numbers(3), m.goal(), constraints=m.constraints(), start_velocity=velocity)


def call_plan_sequence(m):
    segments = [m.segment() for _ in range(m.random.randrange(1, 5))]
    return m.planner.plan_sequence(*m.spoil((m.name("arm"), m.numbers(3), segments))).trajectory


def call_plan_many(m):
    requests = [m.request() for _ in range(m.random.randrange(4))]
    results = m.planner.plan_many(requests, threads=m.random.choice([1, 2, None]) if m.chance(0.95) else m.number())
    return [result.trajectory for result in results if result.solved]


def call_stop(m):
    motion = m.motion()
    return m.planner.stop(*m.spoil((m.name("arm"), motion, m.instant(motion))))


def call_replan(m):
    motion = m.motion()
    return m.planner.replan("arm", motion, m.instant(motion), m.goal(), constraints=m.constraints())


def call_verify(m):
    choices = {
        "start": lambda: m.numbers(3),
        "goals": m.goal,
        "jerk": lambda: True,
        "max_deviation": m.length,
        "gap_tolerance": m.length,
        "at_rest": lambda: False,
        "start_velocity": lambda: m.numbers(3),
        "limits": lambda: m.planner.motion_limits("arm"),
    }
    named = {key: choices[key]() for key in m.random.sample(sorted(choices), m.random.randrange(4))}
    m.planner.verify(*m.spoil((m.name("arm"), m.motion())), **named)


def call_verify_multi(m):
    m.planner.verify_multi({m.name("arm"): m.motion()}, {m.name("arm"): m.numbers(3)}, {m.name("arm"): m.goal()})


def call_cut(m):
    motion = m.motion()
    part = motion.slice(*sorted([m.instant(motion), m.instant(motion)]))
    return part if m.chance(0.5) else part.followed_by(m.motion())


def call_scene(m):
    kind = m.random.randrange(5)
    if kind == 0:
        m.planner.add_box(m.name("box"), [m.length() / 5 for _ in range(3)], m.reached())
    elif kind == 1:
        m.planner.add_sphere(m.name("ball"), m.length() / 5, m.pose())
    elif kind == 2:
        m.planner.remove_object(m.name("box", "ball"))
    elif kind == 3:
        m.planner.make_planner("arm", {**m.options(), "timing": m.name("toppra", "ruckig", "none")})
    else:
        m.planner.set_motion_limits("arm", m.length(), m.length(), 10 * m.length())


MOTION_CALLS = {
    name.removeprefix("call_"): call for name, call in sorted(globals().items()) if name.startswith("call_")
}


class Cases:
    """Runs calls, and counts how each ends."""

    def __init__(self, directory, *, show):
        self.directory, self.show = directory, show
        self.counts = Counter()

    def attempt(self, name, call):
        """A call; returns what it returns, or None where it is refused. Raises what no call may raise."""
        if self.show:
            print(name, flush=True)
        began = time.process_time()
        faulthandler.dump_traceback_later(4 * MAX_SECONDS, exit=True)  # other processes may have the cores
        try:
            result = call()
            self.counts["accepted"] += 1
            return result
        except srmp.Error as error:
            self.counts["refused"] += 1
            if self.show:
                print("  ", error)
            if len(str(error)) >= 500 or "\n" in str(error):
                raise AssertionError(f"{name}: not one short sentence: {error}") from error
        except TypeError as error:
            self.counts["TypeError"] += 1
            if self.show:
                print("  ", "TypeError:", error)
        finally:
            faulthandler.cancel_dump_traceback_later()
            if (spent := time.process_time() - began) > MAX_SECONDS:
                raise AssertionError(f"{name} took {spent:.1f} s of processor time")
        return None

    def scene_calls(self, case):
        """Calls that change and read a scene, and plan in it."""
        maker = Maker(case, self.directory)
        planner = srmp.PlannerInterface()
        planner.add_articulation(urdf_text=URDF, name="arm", end_effector="lower")
        planner.make_planner("arm", {"time_limit": 0.05})
        for _ in range(maker.random.randrange(1, 12)):
            name = maker.random.choice(list(SCENE_CALLS))

            def call(name=name):
                arguments = SCENE_CALLS[name](maker)
                named = arguments if isinstance(arguments, dict) else {}
                rest = () if named else maker.spoil(arguments)
                if self.show:
                    print("  ", rest, named)
                getattr(planner, name.strip())(*rest, **named)

            self.attempt(name, call)
            for read in ("object_names", "robot_names", "last_request", "last_result"):
                getattr(planner, read)

    def motions(self, case):
        """Plans of all kinds, and what can be done with motions."""
        planner = srmp.PlannerInterface()
        planner.add_articulation(
            urdf_text=URDF3, name="arm", end_effector="lower", joint_names=["a", "b", "c"], fixed_joints={"f": 0.0}
        )
        planner.add_box("box", [0.05, 0.05, 0.05], srmp.Pose([1.2, 0.8, 0.0]))
        planner.make_planner("arm", {"time_limit": 0.05})
        maker = MotionMaker(case, self.directory, planner)
        for name in ["plan", *maker.random.choices(list(MOTION_CALLS), k=maker.random.randrange(1, 8))]:
            made = self.attempt(name, lambda name=name: MOTION_CALLS[name](maker))
            maker.motions += made if isinstance(made, list) else [made] if made else []

    def robot_list(self, case):
        """A list of robots (TOML), and each of its robots."""
        maker = Maker(case, self.directory)
        for suffix in ("urdf", "srdf"):
            (self.directory / f"planar.{suffix}").write_bytes((SEEDS / f"{suffix}_planar.{suffix}").read_bytes())
        path = self.directory / "robots.toml"
        path.write_bytes(changed(maker.random, (SEEDS / "robot_list.toml").read_bytes()))
        os.environ["SRMP_ROBOTS"] = str(path)
        try:
            for robot in self.attempt("read", lambda: read_list(path)) or []:
                self.attempt("groups", lambda robot=robot: robot.groups)
                self.attempt("add", lambda robot=robot: srmp.PlannerInterface().add_robot(robot.name))
        finally:
            del os.environ["SRMP_ROBOTS"]

    def data_set_spec(self, case):
        """A spec of a data set (YAML)."""
        maker = Maker(case, self.directory)
        (self.directory / "scene.yaml").write_bytes((SEEDS / "session_pose.yaml").read_bytes().partition(b"%%%")[2])
        path = self.directory / "spec.yaml"
        path.write_bytes(changed(maker.random, (SEEDS / "data_set_spec.yaml").read_bytes()))
        if spec := self.attempt("read", lambda: srmp.datasets.read_spec(path)):
            assert srmp.datasets.Spec.from_dict(spec.to_dict(), spec.files).identity == spec.identity


DOORS = {"scene_calls": 300, "motions": 150, "robot_list": 200, "data_set_spec": 100}
"""Cases in the normal test run: a few seconds of each."""


def run_door(name, directory, options):
    """Returns the number of faults."""
    cases, faults, start, case = Cases(directory, show=options.show), 0, time.monotonic(), options.first
    end = options.first + (options.cases or DOORS[name])
    while time.monotonic() < start + 60 * options.minutes if options.minutes else case < end:
        if options.show:
            print(f"case {case} of {name}", flush=True)
        try:
            getattr(cases, name)(case)
        except Exception as error:  # whatever it is, it is what this program looks for
            faults += 1
            print(f"FAULT in case {case} of {name}: {type(error).__name__}: {str(error)[:300]}", file=sys.stderr)
        case += 1
    print(
        f"{name:16} {case - options.first:9} cases {dict(cases.counts)} {faults} faults  "
        f"{time.monotonic() - start:.1f} s",
        flush=True,
    )
    return faults


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("doors", nargs="*", metavar="DOOR", help=", ".join(DOORS))
    parser.add_argument("--cases", type=int, default=0, help="of each door; default: a few seconds")
    parser.add_argument("--from", type=int, default=0, dest="first", help="number of the first case")
    parser.add_argument("--minutes", type=float, default=0, help="of each door, instead of a number of cases")
    parser.add_argument("--show", action="store_true")
    options = parser.parse_args(arguments)
    if unknown := set(options.doors) - set(DOORS):
        parser.error(f"no such door: {', '.join(sorted(unknown))}; there are {', '.join(DOORS)}")
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_AS, (MAX_ADDRESSES, MAX_ADDRESSES))
    warnings.simplefilter("ignore")
    faults = 0
    with tempfile.TemporaryDirectory() as directory:
        os.chdir(directory)  # for files of relative names
        for name in options.doors or DOORS:
            faults += run_door(name, Path(directory), options)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
