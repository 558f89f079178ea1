"""Bad input: one sentence that helps, of the right type, and nothing half-added to the scene afterwards."""

import numpy as np
import pytest

import srmp

NAN = float("nan")


def urdf(body):
    return f"<robot name='r'><link name='a'/><link name='b'/>{body}</robot>"


def tree(joint):
    return urdf(f"<joint name='j' type='revolute'><parent link='a'/><child link='b'/>{joint}</joint>")


SCENE = [
    (lambda p: p.add_box("box", size=[1, 2]), "size of box 'box' must be 3 numbers"),
    (lambda p: p.add_box("box", size=[1, 2, -3]), "'box'.*-3"),
    (lambda p: p.add_box("box", size=[1, 2, NAN]), "'box'.*NaN"),
    (lambda p: p.add_box("box", size="big"), "size of box 'box' must be numbers, but is 'big'"),
    (lambda p: p.add_box("box", size=[1, 1, 1], padding=-0.1), "padding.*-0.1"),
    (lambda p: p.add_box("table", size=[1, 1, 1]), "'table'"),
    (lambda p: p.add_box("arm", size=[1, 1, 1]), "'arm'"),
    (lambda p: p.add_box("", size=[1, 1, 1]), "name"),
    (lambda p: p.add_sphere("sphere", radius=0), "'sphere'.*0"),
    (lambda p: p.add_cylinder("can", radius=0.1, length=float("inf")), "'can'.*infinity"),
    (lambda p: p.add_capsule("pill", radius=-1, length=1), "'pill'.*-1"),
    (lambda p: p.add_cone("cone", radius=NAN, length=1), "'cone'.*NaN"),
    (lambda p: p.add_mesh("mesh"), "needs either a path or vertices"),
    (lambda p: p.add_mesh("mesh", vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles=[[0, 1, 7]]), "'mesh'.*7"),
    (
        lambda p: p.add_mesh("mesh", vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles=[[0, 1, 1.5]]),
        "whole vertex numbers",
    ),
    (lambda p: p.add_mesh("mesh", vertices=[[0, 0, 0, 0]]), r"shape \(n, 3\)"),
    (lambda p: p.add_mesh("mesh", vertices=np.eye(3), scale=[1, 2]), "scale of mesh 'mesh'"),
    (lambda p: p.add_mesh("mesh", vertices=np.eye(3), scale=[1, 0, 1]), "component 0; each must be finite and not 0"),
    (lambda p: p.add_point_cloud("cloud", []), "'cloud'.*point"),
    (lambda p: p.add_point_cloud("cloud", [[0, 0, NAN]]), "'cloud'"),
    (lambda p: p.add_point_cloud("cloud", [[0, 0, 0]], resolution=0), "'cloud'.*0"),
    (lambda p: p.remove_object("tabel"), "'tabel'.*did you mean 'table'"),
    (lambda p: p.attach_object("table", "arm", "arm7_hnad"), "arm7_hnad.*did you mean 'arm7_hand'"),
    (lambda p: p.attach_object("table", "amr", "arm7_hand"), "'amr'.*did you mean 'arm'"),
    (lambda p: p.detach_object("table"), "'table'"),
    (lambda p: p.set_allowed_collision("table", "nothing"), "'nothing'"),
    (lambda p: p.set_base_pose("amr", srmp.Pose()), "'amr'.*did you mean 'arm'"),
    (lambda p: p.set_qpos("arm", np.zeros(6)), "7.*6"),
    (lambda p: p.set_qpos("arm", np.full(7, 9.0)), "arm7_joint1.*limit"),
    (lambda p: p.set_joint_positions("arm", {"arm7_joint": 0}), "'arm7_joint'"),
    (lambda p: srmp.Pose([0, 0, 0], [0, 0, 0, 0]), "quaternion is zero"),
    (lambda p: srmp.Pose([0, 0]), "3 numbers"),
    (lambda p: srmp.Pose([0, 0, NAN]), "NaN"),
]


@pytest.mark.parametrize(("call", "sentence"), SCENE)
def test_scene_refuses_and_stays_as_it_was(arm, call, sentence):
    before = (arm.object_names, arm.robot_names, arm.get_qpos("arm").tolist())
    with pytest.raises(srmp.InvalidArgument, match=sentence) as error:
        call(arm)
    assert isinstance(error.value, ValueError)
    assert "\n" not in str(error.value)
    assert (arm.object_names, arm.robot_names, arm.get_qpos("arm").tolist()) == before


FILES = [
    (lambda p, d: p.add_mesh("mesh", path=str(d / "no.stl")), "no.stl"),
    (lambda p, d: p.add_mesh("mesh", path=str(d / "empty.stl")), "empty.stl"),
    (lambda p, d: p.add_articulation(urdf_path=str(d / "no.urdf")), "no.urdf"),
    (lambda p, d: p.add_articulation(urdf_path=str(d / "empty.urdf")), "empty.urdf"),
    (lambda p, d: p.add_articulation(urdf_path=str(d / "broken.urdf")), "broken.urdf"),
    (lambda p, d: p.add_articulation(urdf_path=str(d / "inverted.urdf")), "'j'.*lower.*upper"),
    (lambda p, d: p.add_articulation(urdf_path=str(d / "mesh.urdf")), "lost.stl.*tried"),
    (
        lambda p, d: p.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), srdf_path=str(d / "no.srdf"), name="r2"),
        "no.srdf",
    ),
    (
        lambda p, d: p.add_articulation(
            urdf_path=srmp.data_path("arm7.urdf"), srdf_path=str(d / "typo.srdf"), name="r2"
        ),
        "group_stat",
    ),
    (lambda p, d: p.load_moveit_scene(str(d / "no.yaml")), "no.yaml"),
    (lambda p, d: p.load_moveit_scene(str(d / "broken.yaml")), "broken.yaml"),
    (lambda p, d: p.load_moveit_scene(str(d / "half.yaml")), "half.yaml"),
    (lambda p, d: srmp.load_moveit_request(str(d / "empty.stl")), "empty.stl"),
]


@pytest.fixture
def bad_files(tmp_path):
    contents = {
        "empty.stl": "",
        "empty.urdf": "",
        "broken.urdf": "<robot name='r'><link name='a'>",
        "inverted.urdf": tree("<limit lower='1' upper='-1' velocity='1' effort='1'/><axis xyz='0 0 1'/>"),
        "mesh.urdf": tree("<limit lower='-1' upper='1' velocity='1' effort='1'/>").replace(
            "<link name='b'/>",
            "<link name='b'><collision><geometry><mesh filename='package://somewhere/lost.stl'/></geometry></collision></link>",
        ),
        "typo.srdf": "<robot name='arm7'><group_stat name='x' group='arm'/></robot>",
        "broken.yaml": "world: [",
        "half.yaml": """
world:
  collision_objects:
    - id: good
      primitives: [{type: box, dimensions: [1, 1, 1]}]
      primitive_poses: [{position: [5, 0, 0], orientation: [0, 0, 0, 1]}]
    - id: bad
      primitives: [{type: box, dimensions: [1, 1, -1]}]
      primitive_poses: [{position: [5, 0, 0], orientation: [0, 0, 0, 1]}]
""",
    }
    for name, text in contents.items():
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(("call", "sentence"), FILES)
def test_files_are_refused_whole(arm, bad_files, call, sentence):
    before = (arm.object_names, arm.robot_names)
    with pytest.raises(srmp.FileError, match=f"(?s){sentence}") as error:
        call(arm, bad_files)
    assert isinstance(error.value, OSError)
    assert (arm.object_names, arm.robot_names) == before


PLANNERS = [
    ({"planner_id": "wAstr"}, "no planner 'wAstr', did you mean 'wAstar'"),
    ({"planner_id": "wAstar", "time_limt": 5}, "no option 'time_limt', did you mean 'time_limit'"),
    ({"planner_id": "wAstar", "weight": 0.5}, "'weight' is 0.5; it must be at least 1"),
    ({"planner_id": "wAstar", "weight": "heavy"}, "'weight' is 'heavy'; it must be a number"),
    ({"planner_id": "wAstar", "weight": NAN}, "'weight' is NaN"),
    ({"planner_id": "wAstar", "time_limit": 0}, "'time_limit' is 0; it must be above 0"),
    ({"planner_id": "wAstar", "resolution": 1e300}, "'resolution' is 1e\\+300; it must be above 0 and at most 360"),
    ({"planner_id": "auto", "clearance": 1e16}, "'clearance' is 1e\\+16; it must be at least 0 and at most 1000"),
    ({"planner_id": "wAstar", "time_limit": None}, "'time_limit' is None"),
    ({"planner_id": "wAstar", "heuristic": "bsf"}, "'heuristic' is 'bsf', did you mean 'bfs'"),
    ({"planner_id": "wPASE", "num_threads": 1.5}, "'num_threads' is 1.5; it must be a whole number"),
    ({"planner_id": "xECBS", "num_threads": 0}, "'num_threads' is 0; it must be above 0 and at most 1024"),
    ({"planner_id": "auto", "num_threads": 1e6}, "'num_threads' is 1e\\+06; it must be above 0 and at most 1024"),
    ({"planner_id": "auto", "improve_time": -1}, "'improve_time' is -1; it must be at least 0"),
    ({"planner_id": "auto", "improve_rounds": -1}, "'improve_rounds' is -1; it must be at least 0"),
    ({"planner_id": "auto", "improve_rounds": 0.5}, "'improve_rounds' is 0.5"),
    ({"planner_id": "auto", "final_weight": 0.9}, "'final_weight' is 0.9; it must be at least 1"),
    ({"clearance": 1j}, "'clearance' is 1j; it must be a number, a string, True or False, or a list of strings"),
    ({"clearance": True}, "'clearance' is true; it must be a number"),
    ({"clearance": float("inf")}, "'clearance' is infinity; it must be a finite number, at least 0"),
    ({"planner_id": "wAstar", "shortcut": "maybe"}, "'shortcut' is 'maybe'; it must be true or false"),
    ({"planner_id": 7}, "'planner_id' is 7; it must be a word"),
    ({"planner_id": "wAstar", "heuristic": "zzzzzzzzz"}, "'heuristic' is 'zzzzzzzzz'; known are 'joint_euclidean',"),
    ({"planner_id": "wAstar", "heuristic_arm": "bfs"}, "no option 'heuristic_arm', did you mean 'heuristic'"),
    ({"planner_id": "wPASE", "i_weight": 0.5}, "'i_weight' is 0.5; it must be at least 1"),
    ({"planner_id": "wPASE", "i_heuristic": 7}, "'i_heuristic' is 7; it must be a word"),
    ({"planner_id": "wAstar", "i_weight": 2}, "no option 'i_weight', did you mean 'weight'"),
    (
        {"planner_id": "auto", "heuristic_arm": "bfs"},
        "options for robot 'arm' alone, such as 'heuristic_arm', but it is the only one",
    ),
    ("wAstar", "must be a dictionary"),
]


@pytest.mark.parametrize(("options", "sentence"), PLANNERS)
def test_planner_options(arm, options, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        arm.make_planner("arm", options)


def goal_of(q):
    return srmp.GoalConstraint(srmp.GoalType.JOINTS, q)


QUESTIONS = [
    (lambda p, q: p.plan("amr", q, goal_of(q)), "'amr'.*did you mean 'arm'"),
    (lambda p, q: p.plan(["arm", "arm2"], q, goal_of(q)), "use plan_multi for many"),
    (lambda p, q: p.plan("arm", q[:6], goal_of(q)), "start of 'arm'.*7.*6"),
    (lambda p, q: p.plan("arm", [NAN] * 7, goal_of(q)), "start of 'arm'.*arm7_joint1.*NaN"),
    (lambda p, q: p.plan("arm", q, goal_of(np.zeros(8))), "goal of 'arm' has 8 values.*7 planned"),
    (lambda p, q: p.plan("arm", q, []), "must be a GoalConstraint, a Pose, a configuration"),
    (lambda p, q: p.plan("arm", q, {}), "goal of 'arm' names no joint"),
    (lambda p, q: goal_of([[]]), "target"),
    (lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSE, [1, 2, 3]), "a pose is 7 numbers"),
    (lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSE, [0, 0, 0, 0, 0, 0, 0]), "quaternion is zero"),
    (lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSITION, [1, float("inf"), 3]), "infinity"),
    (lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSITION, srmp.Pose()), "a Pose is a target for GoalType.POSE"),
    (
        lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose(), position_tolerance=0),
        "position_tolerance is 0",
    ),
    (
        lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose(), rotation_tolerance=[0.1, -1, 0.1]),
        "rotation_tolerance is -1 for y",
    ),
    (
        lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSE, srmp.Pose(), rotation_tolerance=[0.1, 0.1]),
        "one number or three",
    ),
    (
        lambda p, q: srmp.GoalConstraint(srmp.GoalType.POSITION, [0, 0, 1], position_tolerance=float("inf")),
        "leave every axis free",
    ),
    (lambda p, q: p.make_planner(["arm", "arm"], {}), "'arm' is named twice"),
    (lambda p, q: p.make_planner([], {}), "at least one robot"),
    (lambda p, q: p.compute_fk("arm", q, "arm7_hnad"), "did you mean 'arm7_hand'"),
    (lambda p, q: p.is_state_colliding("arm", q[:3]), "7.*3"),
    (lambda p, q: p.plan_multi({}, {"arm": goal_of(q)}), "'arm' has a goal but no start"),
    (lambda p, q: p.load("a\0b"), r"a path cannot hold a null character, as 'a\\x00b' does"),
    (lambda p, q: p.load("a\ud800"), r"a path must be text in characters that exist in UTF-8, but is 'a\\ud800'"),
    (lambda p, q: p.plan("arm", q + 1j, goal_of(q)), "start.* must be real numbers, but is array"),
]


@pytest.mark.parametrize(("call", "sentence"), QUESTIONS)
def test_questions(arm, ready, call, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence):
        call(arm, ready)
