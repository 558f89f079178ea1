"""Robots that fly: a floating base is planned together with the arm."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from support import needs_example_robot_data, refuses

import srmp

BOX = [[-3, -3, 0], [3, 3, 3]]
NAMES = ["base/x", "base/y", "base/z", "base/yaw", "base/pitch", "base/roll"]
# name: (edge lengths, centre) [m] of a wall with a window, 0.9 m wide and high
WALL = {
    "wall left": ([0.1, 2.55, 3], [0, 1.725, 1.5]),
    "wall right": ([0.1, 2.55, 3], [0, -1.725, 1.5]),
    "sill": ([0.1, 0.9, 1.05], [0, 0, 0.525]),
    "lintel": ([0.1, 0.9, 1.05], [0, 0, 2.475]),
}
GOAL = srmp.Pose.from_rpy([1.6, 0.4, 1.2], [0.4, 0.7, -0.6])
PLATE = """<robot name='plate'><link name='plate'>
  <inertial><mass value='2'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.2'/></inertial>
  <collision><geometry><box size='0.6 0.6 0.05'/></geometry></collision></link></robot>"""


def add_boxes(planner, boxes):
    for name, (size, centre) in boxes.items():
        planner.add_box(name, size, srmp.Pose(p=centre))
    return planner


def flying_arm():
    """arm7, which flies, and a wall with a window."""
    planner = srmp.PlannerInterface()
    planner.add_robot("arm7", floating_bounds=BOX)
    return add_boxes(planner, WALL)


def start_of(planner):
    q = np.zeros(13)
    q[:3], q[6:] = [-1.5, -1.0, 0.5], planner.get_group_states("arm7")["ready"][6:]
    return q


def flying_plate(slot=True):
    """A plate, 0.6 m wide, and a wall with a slot, 0.16 m wide, through which it fits upright."""
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=PLATE, floating_bounds=[[-1, -1, -1], [1, 1, 1]])
    walls = {side: ([0.05, 1.6, 3.2], [0, 0.88 * sign, 0]) for side, sign in (("left", 1), ("right", -1))}
    return add_boxes(planner, walls if slot else {})


@pytest.fixture(scope="module")
def flown():
    planner = flying_arm()
    return planner, planner.plan(start_of(planner), GOAL)


def rotation(yaw, pitch, roll):
    """Written out, from the axes: about z, then about the new y, then about the new x."""
    (cy, cp, cr), (sy, sp, sr) = np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    return about_z @ about_y @ about_x


class FreeFlyer:
    """The arm by Pinocchio alone, with its own joint of six degrees of freedom, and the wall by Coal."""

    def __init__(self):
        self.pin = pin = pytest.importorskip("pinocchio")
        coal = pytest.importorskip("coal")
        urdf, srdf = srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf")
        self.model = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())
        self.geometry = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION)
        for name, (size, centre) in WALL.items():
            place = pin.SE3(np.eye(3), np.array(centre, dtype=float))
            self.geometry.addGeometryObject(pin.GeometryObject(name, 0, 0, place, coal.Box(*size)))
        self.geometry.addAllCollisionPairs()
        pin.removeCollisionPairs(self.model, self.geometry, srdf)
        self.data, self.geometry_data = self.model.createData(), self.geometry.createData()

    def q(self, positions):
        turned = self.pin.Quaternion(rotation(*positions[3:6]))
        return np.concatenate([positions[:3], turned.coeffs(), positions[6:]])

    def collides(self, positions):
        return self.pin.computeCollisions(
            self.model, self.data, self.geometry, self.geometry_data, self.q(positions), True
        )

    def hand(self, positions):
        self.pin.framesForwardKinematics(self.model, self.data, self.q(positions))
        return self.data.oMf[self.model.getFrameId("arm7_hand")].homogeneous


def require_flight(trajectory, reached=None):
    """Through the window, and free by Pinocchio's free-flyer and Coal at every instant."""
    assert trajectory.certificate.holds
    path = np.array([trajectory.sample(t) for t in np.arange(0, trajectory.duration, 0.02)])
    in_window = path[np.abs(path[:, 0]) < 0.2]
    assert len(in_window) > 0
    assert np.abs(in_window[:, 1]).max() < 0.45
    assert np.abs(path[:, 4]).max() <= np.pi / 2
    flyer = FreeFlyer()
    assert flyer.collides([0, 0.6, 1.0, *path[0, 3:]])  # in the wall
    assert not any(flyer.collides(q) for q in path)
    if reached is not None:
        np.testing.assert_allclose(flyer.hand(trajectory.positions[-1]), reached.matrix(), atol=1e-3)


def test_an_arm_flies_through_a_window_and_reaches_a_pose(flown):
    planner, trajectory = flown
    assert trajectory.joint_names[:6] == NAMES
    assert planner.get_joint_limits("arm7")[4].tolist() == [-np.pi / 2, np.pi / 2, 1.0]
    require_flight(trajectory, GOAL)


def test_an_arm_flies_through_a_window_to_a_configuration():
    planner = flying_arm()
    goal = start_of(planner)
    goal[:6] = [1.5, 1.0, 2.0, 2.5, -0.8, 3.0]
    trajectory = planner.plan(start_of(planner), goal)
    assert np.abs(np.remainder(trajectory.positions[-1] - goal + np.pi, 2 * np.pi) - np.pi).max() < 1e-9
    require_flight(trajectory)


def test_the_same_flight_every_time(flown):
    planner = flying_arm()
    assert planner.plan(start_of(planner), GOAL) == flown[1]


def test_a_plate_rolls_upright_to_fit_through_a_slot():
    planner = flying_plate()
    target = srmp.Pose.from_rpy([0.6, 0.2, -0.1], [0.2, 0.1, 2.0])
    trajectory = planner.plan([-0.6, 0, 0, 0, 0, 0], target)
    assert trajectory.joint_names == NAMES
    assert trajectory.certificate.holds
    np.testing.assert_allclose(
        planner.compute_fk("plate", trajectory.positions[-1]).matrix(), target.matrix(), atol=1e-3
    )
    through = [q for q in map(trajectory.sample, np.arange(0, trajectory.duration, 0.01)) if abs(q[0]) < 0.02]
    assert through
    for q in through:  # the plate's normal lies across the slot
        assert abs(rotation(*q[3:])[1, 2]) > 0.8


@needs_example_robot_data
@pytest.mark.parametrize("robot", ["hector", "iris_simple"])
@pytest.mark.filterwarnings("ignore::srmp.RobotWarning")
def test_listed_quadrotors_fly_with_bounds(robot):
    planner = srmp.PlannerInterface()
    refuses(lambda: planner.add_robot(robot), "it flies: give floating_bounds", srmp.NotSupported)
    planner.add_robot(robot, floating_bounds=BOX)
    add_boxes(planner, WALL)
    trajectory = planner.plan([-1.5, -1, 1, 0, 0, 0], [1.5, 1, 1, np.pi / 2, 0, 0])
    assert trajectory.joint_names == NAMES
    assert trajectory.certificate.holds


def test_every_orientation_is_reached():
    planner = flying_plate(slot=False)
    generator = np.random.default_rng(7)
    turns = [srmp.Pose(p=[0.3, -0.4, 0.5], q=q) for q in generator.normal(size=(40, 4))]
    turns += [srmp.Pose.from_rpy([0, 0, 0], [roll, np.pi / 2 * s, 1.0]) for s in (-1, 1) for roll in (-2.0, 0, 3.0)]
    for pose in turns:
        found = planner.compute_ik("plate", pose)
        assert len(found) > 0
        for q in found:
            assert np.abs(q[4]) <= np.pi / 2
            np.testing.assert_allclose(rotation(*q[3:]), pose.matrix()[:3, :3], atol=1e-3)


def test_a_base_is_planned_level_by_the_names_of_its_joints():
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=PLATE, floating_bounds=[[-1, -1, -1], [1, 1, 1]], joint_names=NAMES[:4])
    assert planner.get_joint_names("plate") == NAMES[:4]
    place = planner.compute_fk("plate", [0.1, 0.2, 0.3, 0.4]).matrix()
    np.testing.assert_allclose(place[:3, :3], rotation(0.4, 0, 0), atol=1e-12)
    np.testing.assert_allclose(place[:3, 3], [0.1, 0.2, 0.3], atol=1e-12)


def test_limits_of_the_motion():
    planner = flying_plate(slot=False)
    limits = dict.fromkeys(NAMES[:3], 0.2) | dict.fromkeys(NAMES[3:], 0.5)
    planner.set_motion_limits("plate", velocity=limits, torque={"base/z": 25.0})
    trajectory = planner.plan(np.zeros(6), [0.5, 0, 0.5, 1.0, 0, 0.5])
    assert trajectory.certificate.holds
    assert np.abs(trajectory.velocities[:, :3]).max() <= 0.2
    assert trajectory.duration > 2.5
    with pytest.raises(srmp.InvalidArgument, match="effort limit"):
        planner.set_motion_limits("plate", torque="urdf")
    planner.set_motion_limits("plate", torque={"base/z": 10.0})  # less than its weight
    with pytest.raises(srmp.Error, match="torque"):
        planner.plan(np.zeros(6), [0.5, 0, 0.5, 1.0, 0, 0.5])


def test_saved_scenes_keep_the_base(tmp_path, flown):
    planner, trajectory = flown
    planner.save_scene(tmp_path / "scene.json")
    other = srmp.PlannerInterface()
    other.load_scene(tmp_path / "scene.json")
    q = trajectory.positions[-1]
    assert other.get_joint_names("arm7") == planner.get_joint_names("arm7")
    assert other.compute_fk("arm7", q) == planner.compute_fk("arm7", q)


def test_saved_problems_keep_the_base(tmp_path):
    planner = flying_plate()
    motion = planner.plan([-0.6, 0, 0, 0, 0, 0], [0.6, 0, 0, np.pi / 2, 0, 0])
    planner.save(tmp_path / "problem.json")
    other = srmp.PlannerInterface.load(tmp_path / "problem.json")
    assert other.get_joint_limits("plate").tolist() == planner.get_joint_limits("plate").tolist()
    assert other.plan([-0.6, 0, 0, 0, 0, 0], [0.6, 0, 0, np.pi / 2, 0, 0]) == motion
    assert pickle.loads(pickle.dumps(motion)) == motion


def srdf_with(kind):
    joint = f'<virtual_joint name="world" type="{kind}" parent_frame="odom" child_link="arm7_base"/>'
    return Path(srmp.data_path("arm7.srdf")).read_text().replace("</robot>", f"{joint}</robot>")


def test_a_floating_virtual_joint_of_the_srdf_flies():
    for kind, name in (("floating", "world"), ("planar", "base")):
        planner = srmp.PlannerInterface()
        planner.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"), srdf_text=srdf_with(kind), name="arm", floating_bounds=BOX
        )
        assert planner.get_joint_names("arm")[:6] == [n.replace("base", name) for n in NAMES]


def test_a_floating_joint_in_the_middle_of_the_tree_flies():
    urdf = """<robot name='crane'><link name='rail'/><link name='trolley'/><link name='drone'/><link name='hook'/>
      <joint name='slide' type='prismatic'><parent link='rail'/><child link='trolley'/><axis xyz='0 1 0'/>
        <limit lower='-1' upper='1' velocity='1'/></joint>
      <joint name='air' type='floating'><origin xyz='0 0 2' rpy='0 0 1'/><parent link='trolley'/><child link='drone'/>
      </joint>
      <joint name='turn' type='continuous'><parent link='drone'/><child link='hook'/><axis xyz='0 0 1'/>
        <limit velocity='1'/></joint></robot>"""
    planner = srmp.PlannerInterface()
    planner.add_articulation(urdf_text=urdf, floating_bounds=[[-1, -1, -1], [1, 1, 1]])
    assert planner.get_joint_names("crane") == ["slide", *[f"air/{n[5:]}" for n in NAMES], "turn"]
    q = np.array([0.3, 0.2, -0.1, 0.4, 0.5, -0.6, 0.7, 0.8])
    place = planner.compute_fk("crane", q).matrix()
    turned = rotation(1, 0, 0)
    np.testing.assert_allclose(place[:3, :3], turned @ rotation(*q[4:7]) @ rotation(q[7], 0, 0), atol=1e-12)
    np.testing.assert_allclose(place[:3, 3], turned @ q[1:4] + [0, 0.3, 2], atol=1e-12)
    with pytest.warns(srmp.RobotWarning, match="'air' has more than one degree .* origin; floating_bounds plans it"):
        srmp.PlannerInterface().add_articulation(urdf_text=urdf, joint_names=["slide", "turn"], end_effector="hook")


def flying_in_odom():
    """arm7 with a floating virtual joint `world` in the frame odom, 1 m above the floor, and its ready state."""
    planner = srmp.PlannerInterface()
    robot = {"name": "arm", "end_effector": "arm7_hand", "floating_bounds": BOX}
    planner.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), srdf_text=srdf_with("floating"), **robot)
    ready = planner.get_group_states("arm")["ready"][6:]
    planner.set_qpos("arm", [0, 0, 1, 0, 0, 0, *ready])
    return planner, ready


def base_at(pose):
    """MoveIt's state of that virtual joint."""
    transform = {"translation": list(pose.p), "rotation": list(pose.q)}
    return {"header": {"frame_id": "odom"}, "joint_names": ["world"], "transforms": [transform]}


def test_a_moveit_scene_places_the_floating_base(tmp_path):
    planner, ready = flying_in_odom()
    path = tmp_path / "scene.yaml"

    def load(pose):
        path.write_text(json.dumps({"is_diff": True, "robot_state": {"multi_dof_joint_state": base_at(pose)}}))
        return planner.load_moveit_scene(str(path))

    assert load(srmp.Pose.from_rpy([1, -2, 1.5], [0.3, -0.4, 2.0])) == []
    np.testing.assert_allclose(planner.get_qpos("arm"), [1, -2, 1.5, 2.0, -0.4, 0.3, *ready], atol=1e-9)
    (note,) = load(srmp.Pose(p=[0, 0, 3.5]))
    assert "joint 'world/z' of the robot state is at 3.5, outside of its limits" in note
    assert planner.get_qpos("arm")[2] == 1.5


def test_a_moveit_request_starts_with_the_floating_base(tmp_path):
    planner, ready = flying_in_odom()
    flown = [1.5, -2, 1.2, 1.8, -0.2, 0.1, *ready]
    names = planner.get_joint_names("arm")
    goal = {"joint_constraints": [{"joint_name": n, "position": q} for n, q in zip(names, flown, strict=True)]}

    def apply(pose, **change):
        start = {"multi_dof_joint_state": base_at(pose) | change}
        path = tmp_path / "request.yaml"
        path.write_text(json.dumps({"goal_constraints": [goal], "start_state": start}))
        return planner.apply_moveit_request("arm", srmp.load_moveit_request(str(path)))

    problem = apply(srmp.Pose.from_rpy([1, -2, 1.5], [0.3, -0.4, 2.0]))
    np.testing.assert_allclose(problem.start, [1, -2, 1.5, 2.0, -0.4, 0.3, *ready], atol=1e-9)
    assert problem.ignored_joints == []
    motion = planner.plan("arm", problem.start, problem.goals)
    np.testing.assert_allclose(motion.positions[-1], flown)
    with pytest.raises(srmp.PlanningError, match="world/z"):
        planner.plan("arm", apply(srmp.Pose(p=[0, 0, -0.5])).start, problem.goals)
    with pytest.raises(srmp.Error, match="only the planning frame"):
        apply(srmp.Pose(), header={"frame_id": "arm7_hand"})


@pytest.mark.parametrize(
    ("bounds", "sentence"),
    [
        ([[0, 0, 0], [1, 1, 0]], r"floating_bounds: z is from 0 to 0 m; the lower bound must be below the upper one"),
        ([[0, 2, 0], [1, 1, 1]], r"floating_bounds: y is from 2 to 1 m; the lower bound"),
        ([[0, 0, 0], [np.nan, 1, 1]], r"floating_bounds: x is from 0 to NaN m; bounds must be finite numbers"),
        ([[0, 0, -np.inf], [1, 1, 1]], r"floating_bounds: z is from -inf\w* to 1 m; bounds must be finite numbers"),
        ([[0, 0, 0], [1, 1, 1e4]], r"floating_bounds: z is from 0 to 10000 m; at most 1000 m are allowed"),
        ([[0, 0], [1, 1]], "floating_bounds"),
        ([0, 0, 0, 1, 1, 1], "floating_bounds"),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], "floating_bounds has 3 rows; it takes two, the smallest x, y and z"),
        ("wide", "floating_bounds"),
    ],
)
def test_wrong_bounds_are_refused(bounds, sentence):
    planner = srmp.PlannerInterface()
    refuses(lambda: planner.add_robot("arm7", floating_bounds=bounds), sentence)
    assert planner.robot_names == []


def test_a_robot_drives_or_flies():
    both = {"planar_bounds": [[-1, -1], [1, 1]], "floating_bounds": BOX}
    planner = srmp.PlannerInterface()
    refuses(lambda: planner.add_robot("arm7", **both), "planar_bounds and floating_bounds are both given")
    assert planner.robot_names == []
