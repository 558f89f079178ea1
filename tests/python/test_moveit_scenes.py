"""MoveIt's planning scenes and their objects: every row of their tables in docs/moveit.md has a test here."""

import numpy as np
import pytest
from moveit_messages import (
    IN_SCENES,
    SECTIONS,
    TRIANGLE,
    World,
    at,
    attached,
    box,
    near,
    place,
    position,
    row,
    rows_of,
    target,
)

import srmp
from srmp import Pose


@pytest.fixture
def world(tmp_path):
    return World(tmp_path)


def scenes(*fields):
    return row("Planning scenes", *fields)


def objects(*fields):
    return row("Collision objects", *fields)


def attachments(*fields):
    return row("Attached objects", *fields)


# --- scenes -----------------------------------------------------------------------------------------------------------


@scenes("name", "robot_model_name", "object_colors")
def labels(world):
    world.load(name="kitchen", robot_model_name="arm", object_colors=[{"id": "x", "color": {"r": 1}}])
    assert world.planner.object_names == []
    other = srmp.PlannerInterface()
    for name in ("left", "right"):
        other.add_articulation(urdf_path=srmp.data_path("arm7.urdf"), name=name, end_effector="arm7_hand")
    world.planner = other
    state = {"joint_state": {"name": ["arm7_joint1"], "position": [0.3]}}
    world.load(robot_model_name="right", robot_state=state)
    assert other.get_qpos("right")[0] == 0.3
    assert other.get_qpos("left")[0] == 0
    with pytest.raises(srmp.InvalidArgument, match="in the robots 'left' and 'right'"):
        world.load(robot_model_name="middle", robot_state=state)
    with pytest.raises(srmp.InvalidArgument, match="write 'left/arm7_hand'"):
        world.add(box("box", 0, 0, 1, frame="arm7_hand"))
    world.add(box("box", 0, 0, 1, frame="left/arm7_hand"))


@scenes("robot_state.joint_state")
def scene_joints(world):
    upper = world.planner.get_joint_limits("arm")[1, 1]
    state = {
        "name": ["arm7_joint1", "arm7_joint2", "wheel"],
        "position": [0.3, float(upper) + 1, 2],
        "velocity": [1, 1, 1],
    }
    notes = world.load(robot_state={"joint_state": state})
    assert world.planner.get_qpos("arm")[0] == 0.3
    assert len(notes) == 2
    assert "'arm7_joint2'" in notes[0]
    assert "'wheel'" in notes[1]


@scenes("robot_state.multi_dof_joint_state")
def scene_base(world):
    state = {"joint_names": ["base_joint"], "transforms": [{"translation": [0, 0, 1]}]}
    world.add(box("box", 0, 0, 1, frame="arm7_base"), robot_state={"multi_dof_joint_state": state})
    assert near(world.base().p, [0, 0, 1])
    assert near(world.planner.get_object_pose("box").p, [0, 0, 2])


@scenes("robot_state.attached_collision_objects", "robot_state.is_diff", "is_diff")
def diffs(world):
    world.planner.add_box("table", size=[1, 1, 0.1], pose=Pose(p=[0, 0, -2]))
    world.add(box("old"), robot_state={"attached_collision_objects": [attached()], "is_diff": True})
    world.add(box("new"), is_diff=True)
    assert world.planner.object_names == ["cup", "new", "old", "table"]
    world.add(box("full"), is_diff=False)
    assert world.planner.object_names == ["full", "table"]
    world.scene_refused("'table'", world={"collision_objects": [box("table")]})


@scenes("fixed_frame_transforms")
def fixed_frames(world):
    lifted = {"translation": [0, 0, 2]}
    moveit = {"header": {"frame_id": "shelf"}, "child_frame_id": "odom", "transform": lifted}
    tf = {"header": {"frame_id": "shelf"}, "child_frame_id": "board", "transform": lifted}
    world.add(
        box("low", 0, 0, 1, frame="shelf"), box("high", 0, 0, 1, frame="board"), fixed_frame_transforms=[moveit, tf]
    )
    assert near(world.planner.get_object_pose("low").p, [0, 0, 3])
    assert near(world.planner.get_object_pose("high").p, [0, 0, 5])
    world.scene_refused("both unknown", fixed_frame_transforms=[tf])
    clash = {"header": {"frame_id": "odom"}, "child_frame_id": "arm7_base", "transform": lifted}
    world.scene_refused("stand differently", fixed_frame_transforms=[clash])
    world.scene_refused("unknown frame 'shelv'", world={"collision_objects": [box(frame="shelv")]})


@scenes("allowed_collision_matrix.entry_names", "allowed_collision_matrix.entry_values")
def matrix(world):
    names = ["box", "arm7_hand", "arm7_elbow", "arm7_upper_arm"]

    def load(hand, unknown="arm7_hand", **more):
        entries = np.zeros((4, 4), bool)
        entries[0, 1] = entries[1, 0] = hand
        matrix = {"entry_names": [names[0], unknown, *names[2:]], "entry_values": entries.tolist()}
        return world.add(box(), allowed_collision_matrix=matrix, **more)

    allowed = world.planner.allowed_collision
    notes = load(True)
    assert allowed("box", "arm7_hand")
    assert not allowed("box", "arm7_elbow")
    assert any("'arm/arm7_elbow'" in note for note in notes)  # neighbours, which the robot's own rules allow
    assert allowed("arm7_upper_arm", "arm7_elbow")
    load(False, is_diff=True)
    assert not allowed("box", "arm7_hand")
    with pytest.raises(srmp.InvalidArgument, match="did you mean 'arm7_hand'"):
        load(True, unknown="arm7_hnad")
    load(False, unknown="torso")


@scenes("allowed_collision_matrix.default_entry_names", "allowed_collision_matrix.default_entry_values")
def defaults(world):
    allowed = world.planner.allowed_collision
    matrix = {"default_entry_names": ["box", "arm7_hand", "arm7_elbow"], "default_entry_values": [True, True, False]}
    world.add(box(), box("other", 3, 0, 0), allowed_collision_matrix=matrix)
    assert allowed("box", "arm7_shoulder")
    assert allowed("box", "other")
    assert allowed("box", "arm7_hand")
    assert allowed("other", "arm7_hand")
    assert not allowed("box", "arm7_elbow")
    assert not allowed("other", "arm7_shoulder")


@scenes("link_padding", "link_scale")
def padding(world):
    links = world.planner.get_link_names("arm")
    world.planner.add_sphere("ball", radius=0.1, pose=Pose(p=[0, 0, 3]))
    before = world.planner.distance_to_collision("arm", world.ready)
    world.load(link_padding=[{"link_name": link, "padding": 0.02} for link in links])
    assert near(world.planner.distance_to_collision("arm", world.ready), before - 0.02, 1e-6) or before < 0.1
    world.scene_refused("only one padding", link_padding=[{"link_name": "arm7_hand", "padding": 0.02}])
    world.scene_refused("did you mean 'arm7_hand'?", link_padding=[{"link_name": "arm7_hnad", "padding": 0.02}])
    world.scene_refused("must be 0 or above", link_padding=[{"link_name": "arm7_hand", "padding": -1}])
    world.load(link_scale=[{"link_name": "arm7_hand", "scale": 1}])
    world.scene_refused("scale of link 'arm7_hand'", link_scale=[{"link_name": "arm7_hand", "scale": 1.1}])


@scenes("world.collision_objects", "world.octomap")
def world_field(world):
    world.load(world={"collision_objects": [box("a"), box("b", 3, 0, 0)], "octomap": {"octomap": {"data": []}}})
    assert world.planner.object_names == ["a", "b"]
    world.scene_refused("octomap", world={"octomap": {"octomap": {"data": [1]}}})
    world.scene_refused("did you mean 'collision_objects'?", world={"collision_object": []})


# --- objects ----------------------------------------------------------------------------------------------------------


@objects("header", "pose", "id", "type", "primitives", "primitive_poses", "subframe_names", "subframe_poses")
def collision_objects(world):
    shapes = [
        {"type": kind, "dimensions": sizes}
        for kind, sizes in (("box", [0.1, 0.2, 0.3]), ("sphere", [0.1]), ("cylinder", [0.3, 0.1]), ("cone", [0.3, 0.1]))
    ]
    turned = at(1, 0, 0, xyzw=(0, 0, np.sqrt(0.5), np.sqrt(0.5)))  # a quarter turn about z
    rack = {"id": "rack", "type": {"key": "k", "db": ""}, "pose": turned, "primitives": shapes}
    rack |= {"primitive_poses": [at(0.1 * i, 0, 0) for i in range(4)]}
    rack |= {"subframe_names": ["top"], "subframe_poses": [at(0, 0, 1)]}
    unset = box("unset", pose=at(0, 0, 0, xyzw=(0, 0, 0, 0)))
    pose_of = world.planner.get_object_pose
    world.add(rack, unset)
    assert world.planner.object_names == ["rack", "rack_1", "rack_2", "rack_3", "unset"]
    assert near([pose_of(f"rack_{i}").p for i in (1, 2, 3)], [[1, 0.1, 0], [1, 0.2, 0], [1, 0.3, 0]])
    assert near(pose_of("unset").p, [2, 0, 0])
    world.add(box("on_it", 0, 0, 0.5, frame="rack/top"), box("beside", 1, 0, 0, frame="rack_1"), is_diff=True)
    assert near(pose_of("on_it").p, [1, 0, 1.5])
    assert near(pose_of("beside").p, [1, 1.1, 0])
    world.add(box("single", 0, 0, 1, pose=at(0, 0, 2)), is_diff=True)
    world.add(box("on_single", 0, 0, 0, frame="single"), is_diff=True)  # its frame is its pose, not its shape's
    assert near(pose_of("single").p, [0, 0, 3])
    assert near(pose_of("on_single").p, [0, 0, 2])
    saved = world.directory / "saved.json"
    world.planner.save_scene(str(saved))
    world.planner.load_scene(str(saved))
    assert near(target(world.goal(place(position(0.4, 0, 0, frame="rack/top")))), [1, 0.4, 1])
    wrong = rack | {"id": "wrong"}
    world.scene_refused("primitive_poses", world={"collision_objects": [wrong | {"primitive_poses": [at(0, 0, 0)]}]})
    world.scene_refused("subframe", world={"collision_objects": [wrong | {"subframe_poses": []}]})
    prism = [{"type": "prism", "dimensions": [1, 1]}] * 4
    world.scene_refused("prism", world={"collision_objects": [wrong | {"primitives": prism}]})
    world.scene_refused(
        "did you mean 'primitive_poses'?", world={"collision_objects": [wrong | {"primitve_poses": []}]}
    )


@objects("meshes", "mesh_poses")
def meshes(world):
    world.add({"id": "sheet", "meshes": [TRIANGLE], "mesh_poses": [at(0, 0, 3)]})
    assert near(world.planner.get_object_pose("sheet").p, [0, 0, 3])


@objects("planes", "plane_poses")
def planes(world):
    floor = {"id": "floor", "planes": [{"coef": [0, 0, 1, 0]}], "plane_poses": [at(0, 0, 0)]}
    world.scene_refused("plane", world={"collision_objects": [floor]})
    world.scene_refused("plane_poses", world={"collision_objects": [box(plane_poses=[at(0, 0, 0)])]})


@objects("operation")
def operations(world):
    pose_of = world.planner.get_object_pose
    handle = {"subframe_names": ["handle"], "subframe_poses": [at(0, 0, 0.1)]}
    world.add(box("a", **handle), box("b", 3, 0, 0))
    world.add(box("a", 4, 0, 0), is_diff=True)
    assert near(pose_of("a").p, [4, 0, 0])
    world.add(box("a", 0, 0, 1, operation=2, **handle), is_diff=True)
    assert near(pose_of("a_1").p, [4, 0, 1])
    world.add({"id": "a", "operation": "MOVE", "pose": at(0, 0, 5)}, is_diff=True)
    assert near([pose_of("a").p, pose_of("a_1").p], [[0, 0, 5], [0, 0, 6]])
    world.add(
        {"id": "a", "operation": 3, "pose": at(0, 0, 5), "primitive_poses": [at(1, 0, 0), at(2, 0, 0)]}, is_diff=True
    )
    assert near([pose_of("a").p, pose_of("a_1").p], [[1, 0, 5], [2, 0, 5]])
    assert near(target(world.goal(place(position(0.4, 0, 0, frame="a/handle")))), [0.4, 0, 5.1])
    world.add({"id": "a", "operation": 1}, is_diff=True)
    assert world.planner.object_names == ["b"]
    world.add({"operation": 1}, box("c"), is_diff=True)
    assert world.planner.object_names == ["c"]
    for wrong in (
        {"id": "gone", "operation": 1},
        {"id": "gone", "operation": 3},
        box("c", operation=3),
        box("c", operation=4),
        box("c", operation=2, pose=at(0, 0, 1)),
        {"id": "c", "operation": 3, "primitive_poses": [at(0, 0, 0)] * 2},
    ):
        world.scene_refused("", is_diff=True, world={"collision_objects": [wrong]})


# --- attached objects -------------------------------------------------------------------------------------------------


@attachments("link_name", "object", "touch_links", "detach_posture", "weight")
def attached_objects(world):
    pose_of = world.planner.get_object_pose

    def attach(*messages, **scene):
        return world.load(
            robot_state={"is_diff": True, "attached_collision_objects": list(messages)}, is_diff=True, **scene
        )

    world.planner.set_qpos("arm", world.ready)
    attach(attached(touch_links=["arm7_flange"], detach_posture={"joint_names": []}, weight=1.0))
    assert near(pose_of("cup").p, world.hand() @ [0, 0, 0.1])
    assert world.planner.allowed_collision("cup", "arm7_hand")
    assert world.planner.allowed_collision("cup", "arm7_flange")
    assert not world.planner.allowed_collision("cup", "arm7_elbow")
    held = pose_of("cup")
    attach({"object": {"id": "cup", "operation": 1}})
    world.planner.set_qpos("arm", world.ready + 0.2)
    assert near(pose_of("cup").p, held.p)
    attach({"link_name": "arm7_hand", "object": {"id": "cup"}})  # as it is
    assert near(pose_of("cup").p, held.p)
    world.planner.set_qpos("arm", world.ready)
    assert not near(pose_of("cup").p, held.p)
    attach({"link_name": "arm7_hand", "object": {"operation": 1}})
    for wrong, what in (
        (attached("arm7_hnad"), "did you mean 'arm7_hand'?"),
        (attached(touch_links=["arm7_flnage"]), "did you mean 'arm7_flange'?"),
        ({"link_name": "arm7_hand", "object": {"id": "gone"}}, "not in the scene"),
        ({"object": {"id": "cup", "operation": 1}}, "not attached"),
        ({"link_name": "arm7_hand", "object": {"id": "cup", "operation": 3}}, "moved"),
    ):
        state = {"is_diff": True, "attached_collision_objects": [wrong]}
        world.scene_refused(what, robot_state=state, is_diff=True)
    attach(attached())
    world.scene_refused(
        "detach it", is_diff=True, world={"collision_objects": [box("cup", operation=3) | {"primitives": []}]}
    )


@pytest.mark.parametrize(("section", "field"), rows_of(IN_SCENES))
def test_every_row(section, field, world):
    SECTIONS[section][field](world)
