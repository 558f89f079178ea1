"""VAMP's planners on problems read from the standard input, for speed.py: needs vamp and numpy, not srmp.

Reads {"planner": "rrtc" or "aorrtc", "iterations": [of AORRTC], "repeats": 5, "problems": {name: {"start", "goals",
"boxes", "cylinders", "cylinders_as_boxes"}}} as JSON and prints {name: [{"seconds", "cost"}, of each number of
iterations]}; both are null where it found nothing. RRT-Connect's path is simplified by VAMP's own routine with its
default settings, as in VAMP's own benchmarks. Seconds are VAMP's own measurement, the least of the repeats, which all
draw the same samples: those of a Halton sequence from its beginning.
"""

import json
import sys

import vamp


def environment(problem):
    """Cylinders are capsules for VAMP; where the hand comes down on one, its own benchmarks make it a box."""
    made = vamp.Environment()
    for centre, rpy, half_extents in problem["boxes"]:
        made.add_cuboid(vamp.Cuboid(centre, rpy, half_extents))
    for centre, rpy, radius, length in problem["cylinders"]:
        if problem["cylinders_as_boxes"]:
            made.add_cuboid(vamp.Cuboid(centre, rpy, [radius, radius, length / 2]))
        else:
            made.add_capsule(vamp.Cylinder(centre, rpy, radius, length))
    return made


def run(task):
    anytime = task["planner"] == "aorrtc"
    robot, plan, settings, simplification = vamp.configure_robot_and_planner_with_kwargs("panda", task["planner"])
    sampler, found = robot.halton(), {}
    for name, problem in task["problems"].items():
        scene, found[name] = environment(problem), []
        for iterations in task["iterations"] if anytime else [settings.max_iterations]:
            settings.max_iterations = iterations
            best = {"seconds": None, "cost": None}
            for _ in range(task["repeats"]):
                sampler.reset()
                result = plan(problem["start"], problem["goals"], scene, settings, sampler)
                if not result.solved:
                    continue
                path, nanoseconds = result.path, result.nanoseconds
                if not anytime:
                    simple = robot.simplify(path, scene, simplification, sampler)
                    path, nanoseconds = simple.path, nanoseconds + simple.nanoseconds
                if best["seconds"] is None or 1e-9 * nanoseconds < best["seconds"]:
                    best = {"seconds": 1e-9 * nanoseconds, "cost": path.cost()}
            found[name].append(best)
    return found


if __name__ == "__main__":
    print(json.dumps(run(json.load(sys.stdin))))
