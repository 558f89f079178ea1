"""A stand-in for MotionBenchMaker's directory, made of the package's own arm, for checkouts that do not have the data.

Its robot has the names of the Panda: joints, links, groups, files. It is the arm7 with lengths times 1.2 and the axis
of joint 4 reversed, so that configurations of the Panda are configurations of it too. Its scenarios are those of the
data by name, with random boxes; each has five problems.
"""

import itertools
import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

import srmp

SCALE = 1.2
LINKS = ("base", "shoulder", "upper_arm", "elbow", "forearm", "wrist", "palm_mount", "flange")
READY = [0, -0.785, 0, -2.356, 0, 1.571, 0.785]
SCENARIOS = ("bookshelf_small", "bookshelf_tall", "bookshelf_thin", "box", "cage", "table_pick", "table_under_pick")
PROBLEMS = 5
CLEARANCE = 0.01  # [m] of starts and goals; two links are 18 mm apart at READY
GRIPPER = """<robot>
<joint name="panda_joint8" type="fixed"><parent link="panda_link7"/><child link="panda_link8"/></joint>
<link name="panda_link8"/>
<joint name="panda_hand_joint" type="fixed">
  <origin xyz="0 0 0.024"/><parent link="panda_link8"/><child link="panda_hand"/>
</joint>
<link name="panda_hand"><collision><geometry><mesh filename="package://meshes/collision/hand.obj"/></geometry></collision></link>
<joint name="panda_finger_joint1" type="fixed">
  <origin xyz="0 0.065 0.048"/><parent link="panda_hand"/><child link="panda_leftfinger"/><axis xyz="0 1 0"/>
</joint>
<link name="panda_leftfinger">
  <collision><origin xyz="0 0 0.036"/><geometry><box size="0.024 0.018 0.072"/></geometry></collision>
</link>
<joint name="panda_finger_joint2" type="fixed">
  <origin xyz="0 -0.065 0.048"/><parent link="panda_hand"/><child link="panda_rightfinger"/><axis xyz="0 -1 0"/>
</joint>
<link name="panda_rightfinger">
  <collision><origin xyz="0 0 0.036"/><geometry><box size="0.024 0.018 0.072"/></geometry></collision>
</link>
<joint name="panda_grasptarget_hand" type="fixed">
  <origin xyz="0 0 0.105"/><parent link="panda_hand"/><child link="panda_grasptarget"/>
</joint>
<link name="panda_grasptarget"/>
</robot>"""


def write(directory: Path) -> Path:
    """Writes the directory, and returns it."""
    robot = directory / "panda"
    (robot / "meshes" / "collision").mkdir(parents=True)
    (robot / "meshes" / "collision" / "hand.obj").write_text(box_mesh([0.03, 0.072, 0.024], [0, 0, 0.024]))
    ET.ElementTree(urdf()).write(robot / "panda.urdf")
    shutil.copy(robot / "panda.urdf", robot / "panda_spherized.urdf")
    (robot / "panda.srdf").write_text(srdf())
    for number, scenario in enumerate(SCENARIOS):
        write_problems(robot, scenario, np.random.default_rng(number))
    return directory


def urdf() -> ET.Element:
    """The arm7 without its gripper, and another in its place."""
    text = Path(srmp.data_path("arm7.urdf")).read_text()
    for number, link in enumerate(LINKS):
        text = re.sub(rf'"arm7_{link}"', f'"panda_link{number}"', text)
    robot = ET.fromstring(text.replace("arm7", "panda"))
    for child in list(robot):
        if "palm" in child.get("name") or "hand" in child.get("name"):
            robot.remove(child)
    for element in robot.iter():
        for name in ("radius", "length") + (("xyz",) if element.tag == "origin" else ()):
            if name in element.attrib:
                element.set(name, " ".join(f"{SCALE * float(value):.6g}" for value in element.get(name).split()))
    robot.find("joint[@name='panda_joint4']/axis").set("xyz", "0 -1 0")
    robot.find("joint[@name='panda_joint4']/limit").attrib.update(lower="-3.1416", upper="0.0873")  # the Panda's
    for number in range(1, 8):
        robot.find(f"joint[@name='panda_joint{number}']/limit").set("velocity", "2.175" if number < 5 else "2.61")
    robot.extend(ET.fromstring(GRIPPER))
    return robot


def srdf() -> str:
    joints = "".join(f'<joint name="panda_joint{i}" value="{value}"/>' for i, value in enumerate(READY, 1))
    chain = [f"panda_link{number}" for number in range(8)]
    hand = ["panda_hand", "panda_leftfinger", "panda_rightfinger"]
    pairs = [*itertools.pairwise(chain), *((chain[-1], link) for link in hand), (hand[1], hand[2])]
    rules = "\n".join(f'<disable_collisions link1="{a}" link2="{b}" reason="Adjacent"/>' for a, b in pairs)
    group = '<group name="panda_arm"><chain base_link="panda_link0" tip_link="panda_link8"/></group>'
    return (
        f'<robot name="panda">{group}<group_state name="ready" group="panda_arm">{joints}</group_state>{rules}</robot>'
    )


def box_mesh(half: list[float], centre: list[float]) -> str:
    """A box as Wavefront OBJ."""
    corners = [
        np.multiply(half, signs) + centre for signs in np.ndindex(2, 2, 2) for signs in [2 * np.array(signs) - 1]
    ]
    quads = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    triangles = [(a, b, c) for a, b, c, _ in quads] + [(a, c, d) for a, _, c, d in quads]
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in triangles]
    return "\n".join(lines) + "\n"


def write_problems(robot: Path, scenario: str, random: np.random.Generator) -> None:
    """Boxes around the arm, and goals among them, all as MoveIt writes them."""
    directory = robot / "problems" / f"{scenario}_panda"
    directory.mkdir(parents=True)
    for number in range(1, PROBLEMS + 1):
        planner = srmp.PlannerInterface()
        planner.add_articulation(
            urdf_path=str(robot / "panda.urdf"),
            srdf_path=str(robot / "panda.srdf"),
            name="panda",
            group="panda_arm",
            package_dirs=[str(robot)],
        )
        boxes = [([3, 3, 0.1], [0, 0, -0.06])]
        while len(boxes) < 6:
            boxes.append(random_box(planner, f"box{len(boxes)}", random))
        goal = random_goal(planner, random)
        (directory / f"scene{number:04d}.yaml").write_text(scene_text(boxes))
        (directory / f"request{number:04d}.yaml").write_text(request_text(goal))


def random_box(planner: srmp.PlannerInterface, name: str, random: np.random.Generator):
    """One that the arm does not touch at READY."""
    while True:
        angle, radius = random.uniform(-np.pi, np.pi), random.uniform(0.35, 0.75)
        size = random.uniform([0.05, 0.05, 0.05], [0.25, 0.25, 0.4]).round(3).tolist()
        place = np.round([radius * np.cos(angle), radius * np.sin(angle), random.uniform(0.1, 0.9)], 3).tolist()
        planner.add_box(name, size=size, pose=srmp.Pose(p=place))
        if planner.distance_to_collision("panda", READY) > CLEARANCE:
            return size, place
        planner.remove_object(name)


def random_goal(planner: srmp.PlannerInterface, random: np.random.Generator) -> np.ndarray:
    lower, upper = planner.get_joint_limits("panda")[:, 0], planner.get_joint_limits("panda")[:, 1]
    while True:
        q = random.uniform(0.9 * lower, 0.9 * upper)
        if planner.compute_fk("panda", q).p[2] > 0.15 and planner.distance_to_collision("panda", q) > CLEARANCE:
            return q


def scene_text(boxes) -> str:
    objects = "\n".join(
        f"    - {{id: box{k}, primitives: [{{type: box, dimensions: {size}}}], "
        f"primitive_poses: [{{position: {place}, orientation: [0, 0, 0, 1]}}]}}"
        for k, (size, place) in enumerate(boxes)
    )
    return f"name: ''\nworld:\n  collision_objects:\n{objects}\n"


def request_text(goal: np.ndarray) -> str:
    names = ", ".join(f"panda_joint{i}" for i in range(1, 8))
    joints = "\n".join(f"      - {{joint_name: panda_joint{i}, position: {value}}}" for i, value in enumerate(goal, 1))
    return (
        f"group_name: panda_arm\nstart_state:\n  joint_state:\n    name: [{names}]\n    position: {READY}\n"
        f"goal_constraints:\n  - joint_constraints:\n{joints}\n"
    )
