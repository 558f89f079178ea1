"""Goal types, tolerances, several goals at once, and the errors when no trajectory is found.

The C++ program 02_goals.cpp does the same and prints the same numbers.
"""

from math import pi

import srmp
from srmp import GoalConstraint, GoalType, Pose

planner = srmp.PlannerInterface()
planner.add_articulation(
    urdf_path=srmp.data_path("arm7.urdf"),
    srdf_path=srmp.data_path("arm7.srdf"),
    name="arm",
    end_effector="arm7_hand",
)
planner.add_box("floor", size=[2, 2, 0.1], pose=Pose(p=[0, 0, -0.051]))
planner.add_box("post", size=[0.1, 0.1, 0.8], pose=Pose(p=[0.35, 0, 0.4]))
planner.make_planner("arm", srmp.WAStar(weight=10, time_limit=30))
start = [0.9, 0, 0, 1.5, 0, 1.5, 0]


def report(what, goal, q=start):
    try:
        trajectory = planner.plan("arm", q, goal)
    except srmp.PlanningError as error:
        print(f"{what}: {error.status.name}: {error}")
        return
    print(f"{what}: goal {planner.get_planning_stats()['goal_index']}, {trajectory.duration:.17g} s, ends at")
    print(*(f"{x:.17g}" for x in trajectory.positions[-1]))


down = Pose.from_rpy([0.3, -0.4, 0.3], [0, pi, 0])  # fingers down
far = Pose.from_rpy([1.5, 0, 0.3], [0, pi, 0])
inside = Pose.from_rpy([0.35, 0, 0.4], [0, pi, 0])
home = [-0.9, 0, 0, 1.5, 0, 1.5, 0]

report("joints", GoalConstraint(GoalType.JOINTS, home))
report("pose", GoalConstraint(GoalType.POSE, down))
report("position", GoalConstraint(GoalType.POSITION, [0.3, -0.4, 0.3]))

# Where inverse kinematics cannot reach the pose exactly, 1 cm and 5 degrees are accepted.
report(
    "with tolerances",
    GoalConstraint(GoalType.POSE, down, position_tolerance=0.01, rotation_tolerance=5 * pi / 180),
)

# Any one of several: targets of one type in one goal, or a list of goals. Targets out of reach are ignored.
report("one of two poses", GoalConstraint(GoalType.POSE, [far, down]))
report("a pose or a configuration", [GoalConstraint(GoalType.POSE, far), GoalConstraint(GoalType.JOINTS, home)])

# When no trajectory is found, the error has a status and a sentence that says why.
report("out of reach", GoalConstraint(GoalType.POSE, far))
report("inside the post", GoalConstraint(GoalType.POSE, inside))
report("bad start", GoalConstraint(GoalType.POSE, down), q=[0, 0.6, 0, 1.5, 0, 1, 0])

# An invalid argument raises another type of error and changes nothing.
try:
    planner.plan("arm", start[:6], GoalConstraint(GoalType.POSE, down))
except srmp.InvalidArgument as error:
    print(f"refused: {error}")
