"""docs/from-other-packages.md: the calls of each row of its tables are made."""

import re
from pathlib import Path

import numpy as np
import pytest

import srmp
import srmp.robots
from srmp import GoalConstraint, GoalType, Pose

PAGE = Path(__file__).parents[2] / "docs" / "from-other-packages.md"
CALLS, BLOCKS = PAGE.read_text().split("## Its documentation, block by block")
URDF, SRDF = srmp.data_path("arm7.urdf"), srmp.data_path("arm7.srdf")
READY = np.array([0, 0, 0, np.pi / 2, 0, np.pi / 2, 0])
ARM = {"end_effector": "arm7_hand", "urdf_path": URDF}
THEIR_ROBOT = ("end_effector", "description", "default_qpos", "joint_names", "gripper_joint_names")
THEIR_PRIMITIVES = "motion_primitives:\n  - name: long\n    mprims: [[10, 0, 0, 0, 0, 0, 0]]\n"


def add(planner, **more):
    planner.add_articulation(name="second", **ARM, **more)


def add_second(planner):
    add(planner, srdf_path=SRDF, base_pose=Pose(p=[0, 1.5, 0]))


def make(planner, **options):
    planner.make_planner(["arm"], {"planner_id": "wAstar", **options})


def contexts(planner_id, **options):
    """Each option alone, and all of them."""
    one_by_one = [{key: value} for key, value in options.items()]
    return lambda planner: [make(planner, planner_id=planner_id, **chosen) for chosen in [*one_by_one, options]]


def call(method, /, *arguments, **keywords):
    """A call of the planner."""
    return lambda planner: getattr(planner, method)(*arguments, **keywords)


def calls(*names):
    """What is refused where it is looked up, before it is called."""
    return [call(name) for name in names]


def in_module(*names):
    return [lambda planner, name=name: getattr(srmp, name) for name in names]


def in_robots(*names):
    return [lambda planner, name=name: getattr(srmp.robots, name) for name in names]


def of(cls, *names):
    return [lambda planner, name=name: getattr(cls, name) for name in names]


def assign(name, value):
    return lambda planner: setattr(Pose(), name, value)


def sphere(planner):
    planner.add_sphere("ball", 0.05, Pose(p=[1, 1, 1]))
    return planner


def plan_two(planner):
    add_second(planner)
    goal = GoalConstraint(GoalType.JOINTS, [READY + 0.1])
    return planner.plan_multi(dict.fromkeys(["arm", "second"], READY), dict.fromkeys(["arm", "second"], goal))


def of_one_robot(planner):
    add_second(planner)
    options = {"planner_id": "xECBS", "heuristic_arm": "bfs"}
    planner.make_planner(["arm", "second"], options | {"mprim_path_arm": srmp.data_path("primitives/default.yaml")})


def accepted_ids(planner):
    for id_ in ("Astar", "wAstar", "ARAstar", "MHAstar", "wPASE", "xECBS"):
        planner.make_planner(["arm"], {"planner_id": id_})


def pose_goal(planner):
    return planner.plan(READY, GoalConstraint(GoalType.POSE, [Pose(p=[0.1, 0.45, 0.4], q=[0, 1, 0, 0])]))


def joint_goal(planner):
    return planner.plan(READY, GoalConstraint(GoalType.JOINTS, [READY + 0.1]))


def place_and_remove(planner):
    planner.set_base_pose("arm", Pose(p=[0, 0, 0.1]))
    planner.remove_articulation("arm")


def set_and_get(planner):
    planner.set_qpos("arm", READY)
    assert np.array_equal(planner.get_qpos("arm"), READY)


def attach(planner):
    sphere(planner).attach_object("ball", "arm", "arm7_hand", ["arm7_wrist"])
    planner.detach_object("ball")


def four_options(planner):
    make(planner, resolution="5", time_limit="5", weight="10.0")
    make(planner, mprim_path=srmp.data_path("primitives/default.yaml"))


def their_primitives(planner):
    Path("theirs.yaml").write_text(THEIR_PRIMITIVES)
    make(planner, mprim_path="theirs.yaml")
    joint_goal(planner)


def scenes(planner):
    planner.save_scene("scene.json")
    planner.load_scene("scene.json")


def jacobian(planner):
    assert planner.compute_jacobian("arm", READY, "arm7_hand").shape == (6, 7)


def other_quaternions(planner):
    assert np.allclose(Pose([0, 0, 0], [1, 0, 0, 0]).matrix(), np.diag([1, -1, -1, 1]))  # half a turn about x
    assert np.allclose(Pose.from_wxyz([0, 0, 0], [1, 0, 0, 0]).matrix(), np.eye(4))


def other_ik(planner):
    found = planner.compute_ik("arm", planner.compute_fk("arm", READY), READY)
    assert found.shape[1] == 7 and len(found) > 1 and np.allclose(found[0], READY, atol=1e-3)


def reset_all(planner):
    planner.reset()
    assert planner.robot_names == []


def trajectory_names(planner):
    trajectory = joint_goal(planner)
    shape = (len(trajectory.times), 7)
    assert shape == trajectory.positions.shape == trajectory.velocities.shape == trajectory.accelerations.shape


GRID = "no grid of the workspace here"
PLANNED = "every robot may be planned"
COLOURS = "the viewer chooses the colours"
CHECKER = "one exact checker here"
MOVED = {"pose": Pose(p=[1, 1, 1])}
# The beginning of a row: what a refusal says ("": accepted, or different), and the row's calls.
ROWS = {
    "`srmp.save_plan": (r"write trajectory\.save\(path\)", *in_module("save_plan")),
    "`srmp.load_plan": (r"write srmp\.Trajectory\.load\(path\)", *in_module("load_plan")),
    "`srmp.save_scene": (r"write planner\.(save|load)_scene", *in_module("save_scene", "load_scene")),
    "`srmp.GridConfig": (GRID, *in_module("GridConfig", "OccupancyGrid")),
    "`srmp.ViserPlannerInterface": (r"write planner\.show\(\)", *in_module("ViserPlannerInterface")),
    "`srmp.robots.list_available": (
        r"write (available\(\)|find\(name\)|srmp\.InvalidArgument)",
        *in_robots("list_available", "get", "info", "RobotNotFoundError"),
    ),
    "`srmp.robots.download": (
        "nothing is downloaded here",
        *in_robots("download", "download_all", "get_cache_dir", "set_cache_dir", "DownloadError"),
    ),
    "`srmp.robots.register": (
        "it is a line of a TOML file here",
        lambda p: srmp.robots.register(name="mine", urdf_path=URDF, srdf_path=SRDF),
        *(lambda p, key=key: srmp.robots.register("mine.toml", **{key: "x"}) for key in THEIR_ROBOT),
    ),
    "`srmp.robots.unregister": ("registered again replaces", *in_robots("unregister")),
    "`PlannerInterface()": ("", lambda p: srmp.PlannerInterface()),
    "`PlannerInterface(grid": (
        GRID,
        lambda p: srmp.PlannerInterface(grid_config=None),
        *calls("set_grid", "get_grid", "get_grid_config"),
    ),
    "`add_articulation(name=, end": ("", lambda p: add(p, srdf_path=SRDF)),
    '`add_articulation("arm"': ("give them by name", call("add_articulation", "arm", "arm7_hand", URDF)),
    "`add_articulation(joint_names": ("", lambda p: add(p, joint_names=["arm7_joint1", "arm7_joint2"])),
    "`add_articulation(link_names": ("all links of the URDF are read", lambda p: add(p, link_names=[])),
    "`add_articulation(gravity": ("no dynamics here: leave it out", lambda p: add(p, gravity=np.zeros(3))),
    "`add_articulation(planned": (PLANNED, lambda p: add(p, planned=True)),
    "`add_articulation(gripper": ("set_joint_positions", lambda p: add(p, gripper_joint_names=["x"])),
    "`add_articulation(end_effectors": ("goals of several links are", lambda p: add(p, end_effectors=["x"])),
    '`add_robot("panda")': ("", call("add_robot", "arm7", name="other", base_pose=Pose(p=[0, 2, 0]))),
    "`add_robot(planned": (
        f"{PLANNED}|no dynamics|all links|set_joint_positions",
        *(
            call("add_robot", "arm7", **{key: []})
            for key in ("planned", "gravity", "link_names", "gripper_joint_names")
        ),
    ),
    "`add_robot(srdf": ("add_articulation takes another", call("add_robot", "arm7", srdf_path=SRDF)),
    "`set_gripper_qpos": ("write set_joint_positions", call("set_gripper_qpos", "arm", [0.0])),
    "`get_gripper_joint_names": ("the 'gripper' of what add_robot returns", *calls("get_gripper_joint_names")),
    "`remove_articulation(name)`": ("", place_and_remove),
    "`set_qpos(name": ("", set_and_get),
    "`set_qpos(robot_name": (
        "it is '(name|q)' here",
        call("set_qpos", robot_name="arm", qpos=READY),
        call("set_qpos", name="arm", qpos=READY),
        call("get_qpos", articulation_name="arm"),
        call("get_link_names", articulation_name="arm"),
    ),
    "`set_qpos_all": (r"write set_qpos\(name, q\) for each", *calls("set_qpos_all")),
    "`get_articulation_names": ("robot_names", *calls("get_articulation_names", "has_articulation")),
    "`get_move_group_joint_names": (r"write get_joint_names\(name\)", *calls("get_move_group_joint_names")),
    "`get_move_group_joint_limits": (r"write get_joint_limits\(name\)", *calls("get_move_group_joint_limits")),
    "`get_move_group_qpos_dim": (
        r"write (len\(planner\.get_joint_names|get_joint_limits)",
        *calls("get_move_group_qpos_dim", "get_move_group_joint_types"),
    ),
    "`get_active_joint_names": ("write get_all_joint_limits", *calls("get_active_joint_names")),
    "`is_articulation_planned": (PLANNED, *calls("is_articulation_planned", "set_articulation_planned")),
    "`get_link_names": ("", call("get_link_names", "arm")),
    "`get_link_index": ("links go by their names here", *calls("get_link_index")),
    "`Pose(p": ("", other_quaternions),
    "`Pose(matrix": ("position must be one row of numbers", lambda p: Pose(np.eye(4))),
    "`Pose.inv": (r"write (inverse\(\)|p|q, which is|matrix\(\))", *of(Pose(), "inv", "get_p", "get_q")),
    "`pose.p =": ("poses do not change, and q is x, y, z, w", assign("p", [1, 2, 3]), assign("q", [1, 0, 0, 0])),
    "`Pose.set_p": ("poses do not change|numpy.linalg.norm", *of(Pose(), "set_p", "set_q", "distance")),
    "`compute_fk(name": ("", call("compute_fk", "arm", READY)),
    "`compute_fk(articulation": (
        "it is '(name|q)' here",
        call("compute_fk", articulation_name="arm", qpos=READY),
        call("compute_fk", "arm", qpos=READY),
    ),
    "`compute_ik(name, pose": ("", other_ik),
    "`compute_ik(name, ee": (
        "it is '(target|reference)' here",
        call("compute_ik", "arm", ee_pose=Pose(), init_state_val=READY),
        call("compute_ik", "arm", Pose(), init_state_val=READY),
    ),
    "`collision_aware_ik": ("write compute_ik", *calls("collision_aware_ik")),
    "`compute_jacobian(name": ("", jacobian),
    "`compute_jacobian(local": (
        "in world axes here|a column each here",
        call("compute_jacobian", "arm", READY, "arm7_hand", local=True),
        call("compute_jacobian", "arm", READY, "arm7_hand", move_group_only=True),
    ),
    "`get_jacobian": (r"write compute_(jacobian|fk)\(name", *calls("get_jacobian", "get_link_pose")),
    "`compute_joint_velocities": (r"numpy\.linalg\.pinv", *calls("compute_joint_velocities")),
    "`get_manipulability": (r"numpy\.sqrt\(numpy\.linalg\.det", *calls("get_manipulability")),
    "`is_state_colliding(name)": ("needs 'q'", call("is_state_colliding", "arm")),
    "`distance_to_collision()": ("needs 'name' and 'q'", call("distance_to_collision")),
    "`distance_to_self": (
        "write distance_to_collision",
        *calls("distance_to_self_collision", "distance_to_robot_collision"),
    ),
    "`is_robot_colliding": (r"write contacts\(name, q\)", *calls("is_robot_colliding_with_objects")),
    "`get_available_validity": (
        CHECKER,
        *calls("get_available_validity_backends", "get_active_validity_backend"),
        *calls("get_vamp_supported_robots", "is_robot_vamp_supported"),
    ),
    "`is_vamp_state_valid": (r"write not planner\.is_state_colliding", *calls("is_vamp_state_valid")),
    "`add_box(name": ("", call("add_box", "box", np.full(3, 0.1), Pose(p=[1, 1, 1]))),
    "`add_sphere": (
        "",
        call("add_sphere", "ball", 0.1, Pose(p=[1, 1, 1])),
        call("add_cylinder", "can", 0.1, 0.2, Pose(p=[1, 1, 1])),
    ),
    "`add_box(color": (
        COLOURS,
        call("add_box", "box", np.ones(3), color=[1, 0, 0]),
        call("add_sphere", "ball", 0.1, color=[1, 0, 0]),
        call("add_cylinder", "can", 0.1, 0.2, color=[1, 0, 0]),
        call("add_mesh", "mesh", "x.stl", color=[1, 0, 0]),
        call("add_point_cloud", "cloud", np.ones((3, 3)), colors=np.ones((3, 3))),
        *calls("set_object_color"),
    ),
    "`add_box(pose=None": ("pose must be a Pose, but is None", call("add_box", "box", np.ones(3), None)),
    "`add_mesh(name, mesh": ("it is 'path' here", call("add_mesh", "mesh", mesh_path="x.stl")),
    "`add_mesh(name, vert": ("", call("add_mesh", "mesh", vertices=np.eye(3), triangles=[[0, 1, 2]], **MOVED)),
    "`add_point_cloud(name, points": ("", call("add_point_cloud", "cloud", points=np.ones((3, 3)))),
    "`add_point_cloud(name, vert": ("it is 'points' here", call("add_point_cloud", "cloud", vertices=np.ones((3, 3)))),
    "`remove_object": ("", lambda p: sphere(p).remove_object("ball")),
    "`get_object_names": ("object_names", *calls("get_object_names", "has_object")),
    "`update_object_pose": (r"write set_object_pose\(name, pose\)", *calls("update_object_pose")),
    "`attach_object(name": ("", attach),
    "`attach_object(object_name": (
        "it is '(name|robot|link)' here|links have names",
        *(call("attach_object", **{key: "x"}) for key in ("object_name", "robot_name", "link_id", "is_link_name")),
    ),
    "`attach_object(pose": ("it is 'pose_in_link' here", call("attach_object", "ball", "arm", "x", pose=Pose())),
    "`detach_object(name)": ("", attach),
    "`detach_object(name, also": (r"call remove_object\(name\)", call("detach_object", "ball", also_remove=True)),
    "`detach_all_objects": (
        "detach_object|moves with its link",
        *calls("detach_all_objects", "update_attached_bodies_pose", "is_object_attached"),
    ),
    "`set_allowed_collision": ("'allowed' by name", call("set_allowed_collision", "arm", "arm", True)),
    "`save_scene(path)`, `load_scene": ("", scenes),
    "`load_scene(path, clear": ("replaces the whole scene here", call("load_scene", "scene.json", clear=True)),
    '`read_sim(sim, "mujoco"': ("", lambda p: read_a_simulation(p)),
    '`read_sim(sim, "swift"': ("unknown simulator 'swift'; known: mujoco", call("read_sim", None, "swift")),
    "`reset()": ("", reset_all),
    "`reset(reset_robots": ("remove_object removes one", call("reset", reset_robots=False)),
    "`make_planner([name]": ("", lambda p: make(p, weight="10.0")),
    "`make_planner(articulation": (
        "it is '(names|options)' here",
        call("make_planner", articulation_names=["arm"], planner_context={}),
        call("make_planner", ["arm"], planner_context={}),
    ),
    "`planner_id`: `Astar": ("", accepted_ids),
    "`planner_id`: `MGS": (
        "'auto' chooses|no planner MGS",
        lambda p: make(p, planner_id="MGS"),
        *calls("get_mgs_roots"),
    ),
    "`print_available_planners": ("", call("print_available_planners")),
    "`heuristic`: `bfs": ("", lambda p: [make(p, heuristic=name) for name in ("bfs", "joint_euclidean")]),
    "`heuristic`: `joint_euclidean_r": (
        "did you mean 'joint_euclidean'",
        lambda p: make(p, heuristic="joint_euclidean_remove_time"),
    ),
    "`resolution`": ("", four_options),
    "`weight_delta`": ("", contexts("ARAstar", weight="50", weight_delta="10", final_weight="1")),
    "`inadmissible_heuristics`": ("", contexts("MHAstar", inadmissible_heuristics="bfs", w1="20", w2="5")),
    "`i_heuristic`": ("", contexts("wPASE", i_heuristic="bfs", i_weight="2", num_threads="4")),
    "`weight_low_level": (
        "",
        contexts(
            "xECBS",
            weight_low_level_heuristic="50",
            high_level_focal_suboptimality="1.3",
            low_level_focal_suboptimality="1.3",
        ),
    ),
    "`heuristic_NAME`": ("", of_one_robot),
    "an option of another planner": ("has no option 'w1'", lambda p: make(p, planner_id="Astar", w1="20")),
    "`allowed_planning_time`": ("it is 'time_limit' here", lambda p: make(p, allowed_planning_time="5")),
    "a motion-primitive file": (r"theirs\.yaml.*line|theirs\.yaml:\d", their_primitives),
    "`GoalConstraint(GoalType.POSE": ("", pose_goal),
    "`GoalConstraint(joints": (
        "it is 'targets' here|write targets",
        lambda p: GoalConstraint(GoalType.JOINTS, joints=[READY]),
        lambda p: GoalConstraint(GoalType.POSE, poses=[Pose()]),
        lambda p: GoalConstraint(GoalType.POSITION, positions=[[0, 0, 0]]),
        *of(GoalConstraint(GoalType.JOINTS, [READY]), "joints", "poses", "positions"),
    ),
    "`GoalType.MULTI": (
        r"write GoalType\.\w+ with several targets",
        *of(GoalType, "MULTI_GOAL_JOINTS", "MULTI_GOAL_POSE", "MULTI_GOAL_POSITION"),
    ),
    "`plan(start, goal)": ("", joint_goal),
    "`plan(start, goal_constraint": (
        "it is '(goal|starts|goals)' here",
        call("plan", READY, goal_constraint=READY),
        call("plan_multi", start_states={}, goal_constraints={}),
        call("plan_multi", {}, goal_constraints={}),
    ),
    "`plan_multi(starts": ("", plan_two),
    "`plan_screw": (r"write plan_linear.*compat\.mplib", *calls("plan_screw")),
    "`Trajectory.positions": ("", trajectory_names),
    "`get_planning_stats": ("", lambda p: p.get_planning_stats()["status"]),
    "`save_plan": (r"write the save\(path\)", call("save_plan", "plan.txt")),
    "`start_visualizer": (r"write planner\.show\(\)", call("start_visualizer", "viser")),
    "`attach_visualizer": (
        "follows the planner by itself",
        *calls("attach_visualizer", "detach_visualizer", "get_visualizer"),
    ),
}


def read_a_simulation(planner):
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom type='box' size='1 1 1'/></worldbody></mujoco>")
    planner.reset()
    planner.read_sim((model, mujoco.MjData(model)), "mujoco", articulations=[])


def table():
    """First and second cell of each row."""
    rows = re.findall(r"^\| (.+?) \| (accepted|renamed|refused|different) \|", CALLS, re.MULTILINE)
    assert len(rows) == len(ROWS) == len(re.findall(r"^\| (?!call )", CALLS, re.MULTILINE))
    return rows


def blocks():
    """The cells of each row of the last table."""
    rows = re.findall(r"^\| (.+?, \d+) \| (accepted|renamed|refused) \| (.*)\|$", BLOCKS, re.MULTILINE)
    assert len(rows) == len(re.findall(r"^\| (?!block )", BLOCKS, re.MULTILINE)) == 72
    return rows


@pytest.fixture
def planner(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return arm_alone()


def arm_alone():
    planner = srmp.PlannerInterface()
    planner.add_articulation(name="arm", srdf_path=SRDF, **ARM)
    return planner


@pytest.mark.parametrize(("text", "here"), table(), ids=[text for text, _ in table()])
def test_row(planner, text, here):
    make_calls_of_row(planner, text, here)


@pytest.mark.parametrize(("block", "here", "cell"), blocks(), ids=[block for block, _, _ in blocks()])
def test_block_of_their_documentation(block, here, cell, tmp_path, monkeypatch):
    """Each call in a world of its own."""
    monkeypatch.chdir(tmp_path)
    found = ["accepted"]
    for beginning in filter(None, cell.strip().split("; ")):
        ((text, outcome),) = [row for row in table() if row[0].startswith(beginning)]
        make_calls_of_row(arm_alone(), text, outcome)
        found.append(outcome)
    assert here == max(found, key=("accepted", "renamed", "refused").index), block


def make_calls_of_row(planner, text, here):
    ((says, *made),) = [row for beginning, row in ROWS.items() if text.startswith(beginning)]
    assert here in (("renamed", "refused") if says else ("accepted", "different"))
    for one in made:
        if not says:
            one(planner)
            continue
        with pytest.raises(srmp.Error, match=says) as refusal:
            one(planner)
        assert len(str(refusal.value)) < 500 and "\n" not in str(refusal.value)
        assert planner.robot_names == ["arm"]
        assert planner.object_names == []


def test_names_of_the_other_package_are_not_there(planner):
    assert not hasattr(planner, "save_plan") and not hasattr(Pose(), "inv") and not hasattr(srmp, "load_plan")
    assert [kind.name for kind in GoalType] == ["JOINTS", "POSE", "POSITION", "HOLD", "ANY"]
    for owner, name in ((planner, "sav_plan"), (Pose(), "invert"), (srmp, "plan")):
        with pytest.raises(AttributeError, match=f"has no attribute '{name}'"):
            getattr(owner, name)
