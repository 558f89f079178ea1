"""Specs of data sets: one sentence for everything that is wrong."""

import json
import re
from pathlib import Path

import pytest
from data_sets import ROBOT, spec_of

import srmp

pytest.importorskip("pyarrow", reason="data sets need pyarrow: pip install '.[datasets]'")
pytest.importorskip("yaml", reason="specs need PyYAML: pip install '.[datasets]'")

from srmp.datasets.generation import generate
from srmp.datasets.scene import Scene
from srmp.datasets.spec import read_spec

BROKEN = [
    ({"count": 0}, "count is 0; it must be a whole number of at least 1."),
    ({"count": "many"}, "count is 'many'"),
    ({"records_per_shard": 0}, "records_per_shard is 0; it must be a whole number from 1 to 100000."),
    ({"seed": -1}, "seed is -1"),
    ({"clearance": -0.1}, "clearance is -0.1; it must be a number from 0 to 1."),
    ({"clearance": float("nan")}, "clearance is nan"),
    ({"tries": 1.5}, "tries is 1.5; it must be a whole number"),
    ({"skip": 3}, "skip is 3; it must be a list of whole numbers of at least 0."),
    ({"skip": [1.5]}, "skip is [1.5]"),
    ({"skip": [-1]}, "skip is [-1]"),
    ({"skip": "12"}, "skip is '12'"),
    ({"cuont": 3}, "the spec has an unknown field 'cuont', did you mean 'count'?"),
    ({"robots": []}, "robots is []; it must be a list of at least one mapping."),
    ({"robots": [3]}, "robots[0] is 3; it must be a mapping"),
    ({"robots": [{"model": "arm7"}]}, "robots[0] has no 'name'."),
    ({"robots": [{**ROBOT, "name": "a/b"}]}, "robots[0].name is 'a/b'"),
    ({"robots": [{**ROBOT, "name": "a" * 99}]}, "it must be made of at most 60 letters"),
    ({"count": 10**400}, "it must be at most 10000000 times records_per_shard, 2."),
    ({"clearance": 10**400}, "it must be a number from 0 to 1."),
    ({"planner": {"time_limit": 10**400}}, "planner: "),
    ({"start": "x\ny"}, "start is 'x\\ny'; it must be a mapping"),
    ({"scenes": [{"kind": "variations", "scene": "x" * 5000}]}, "it must be a file that exists."),
    (
        {"robots": [{**ROBOT, "model": "arm8"}]},
        "robots[0].model is 'arm8'; it must be one of arm7, did you mean 'arm7'?",
    ),
    ({"robots": [{"name": "arm", "urdf": "none.urdf", "end_effector": "x"}]}, "it must be a file that exists."),
    ({"robots": [{**ROBOT, "srdf": "none.srdf"}]}, "robots[0] has an unknown field 'srdf'"),
    ({"robots": [{**ROBOT, "end_effector": "arm7_hnad"}]}, "did you mean 'arm7_hand'?"),
    ({"robots": [{**ROBOT, "group": "legs"}]}, "robots[0]: "),
    ({"robots": [{**ROBOT, "fixed_joints": {"x": "y"}}]}, "fixed_joints.x is 'y'; it must be a number."),
    (
        {"robots": [{**ROBOT, "base": {"position": [0, 0]}}]},
        "base.position is [0, 0]; it must be 3 finite numbers.",
    ),
    ({"robots": [{**ROBOT, "base": {"rpy": "up"}}]}, "robots[0].base.rpy is 'up'"),
    ({"robots": [{**ROBOT, "base": {"yaw": 1}}]}, "robots[0].base has an unknown field 'yaw'"),
    ({"robots": [{**ROBOT, "tool_length": -1}]}, "robots[0].tool_length is -1"),
    ({"robots": [{**ROBOT, "package_dirs": "x"}]}, "robots[0] has an unknown field 'package_dirs'"),
    ({"robots": [ROBOT, ROBOT]}, "two robots have the name 'arm'."),
    ({"scenes": []}, "scenes is []"),
    ({"scenes": [{"kind": "tabel"}]}, "scenes[0].kind is 'tabel'; it must be one of table, shelf"),
    ({"scenes": [{"kind": "table", "weight": 0}]}, "scenes[0].weight is 0"),
    (
        {"scenes": [{"kind": "table", "objects": -1}]},
        "[0].objects is -1; it must be a whole number from 0 to 500.",
    ),
    ({"scenes": [{"kind": "table", "scale": 0}]}, "scenes[0].scale is 0"),
    ({"scenes": [{"kind": "table", "bars": 3}]}, "scenes[0] has an unknown field 'bars'"),
    ({"scenes": [{"kind": "table"}, {"kind": "table"}]}, "two scenes have the name 'table'"),
    ({"scenes": [{"kind": "table", "start": {"from": "regoin"}}]}, "did you mean 'region'?"),
    ({"scenes": [{"kind": "table", "goal": {"from": "region", "pose": 1}}]}, "scenes[0].goal.pose is 1"),
    (
        {"start": {"from": "states", "states": ["raedy"]}},
        "states[0] is 'raedy'; it must be a state of 'arm': ready",
    ),
    ({"start": {"from": "states", "states": [[1, 2]]}}, "start.states[0] is [1, 2]; it must be 7 finite numbers."),
    ({"start": {"from": "states", "states": []}}, "start.states is []"),
    ({"goal": {"from": "configuration", "regions": ["x"]}}, "goal has an unknown field 'regions'"),
    ({"scenes": [{"kind": "function", "function": "no"}]}, "scenes[0].function is 'no'; it must be module:function."),
    ({"scenes": [{"kind": "function", "function": "no_module:f"}]}, "in a module that is one file"),
    ({"scenes": [{"kind": "variations", "scene": "none.yaml"}]}, "none.yaml'; it must be a file that exists."),
    ({"scenes": [{"kind": "variations"}]}, "scenes[0] has no 'scene'."),
    ({"planner": {"planner_id": "autto"}}, "planner: "),
    ({"planner": {"time_limit": -1}}, "planner: "),
    ({"planner": {"certify": False}}, "planner.certify is False; in data sets it must be True."),
    ({"planner": {"improve_time": 0.5}}, "planner.improve_time is 0.5"),
    (
        {"planner": {"planner_id": "ARAstar"}},
        "planner.planner_id is 'ARAstar', which improves its path until the clock",
    ),
    ({"planner": {"planner_id": "AMRAstar"}}, "planner.planner_id is 'AMRAstar'"),
    ({"planner": {"timing": "none"}}, "planner.timing is 'none'"),
    ({"planner": []}, "planner is []; it must be a mapping"),
    ({"planner": {"sample_period": -1}}, "planner: option 'sample_period' is -1; it must be above 0"),
    (
        {"planner": {"sample_rate": 50}},
        "planner.sample_rate is 50; in data sets rows are a planner.sample_period apart.",
    ),
    ({"planner": {"heuristic": "shortest"}}, "planner: option 'heuristic' is 'shortest'; known are 'joint_euclidean'"),
    ({"planner": {"mprim_path": "mine.yaml"}}, "planner.mprim_path is 'mine.yaml'; in data sets it must be empty"),
    ({"planner": {"mprim_path_arm": "mine.yaml"}}, "planner.mprim_path_arm is 'mine.yaml'"),
    (
        {"planner": {"planner_id": "CBS"}},
        "planner.planner_id is 'CBS', which plans for many robots only; there is one.",
    ),
]


@pytest.mark.parametrize(("change", "sentence"), BROKEN, ids=[str(change)[:60] for change, _ in BROKEN])
def test_a_broken_spec_is_one_sentence(change, sentence, tmp_path):
    with pytest.raises(srmp.Error) as caught:
        generate({**spec_of(), **change}, tmp_path / "set", workers=1)
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "set").exists()


def whole_spec(directory):
    """A spec with every field that there is."""
    (directory / "scene.json").write_text(
        json.dumps({"scene": {"objects": [an_object(shape={"kind": "box", "size": [0.1, 0.1, 0.1]})]}})
    )
    (directory / "request.yaml").write_text(A_REQUEST)
    (directory / "whole_scenes.py").write_text("def f(random):\n    return None\n")
    robot = {
        **{"name": "arm", "urdf": srmp.data_path("arm7.urdf"), "srdf": srmp.data_path("arm7.srdf"), "package_dirs": []},
        **{"end_effector": "arm7_hand", "group": "arm", "fixed_joints": {}, "tool_length": 0.1},
        "base": {"position": [0, 0, 0], "rpy": [0, 0, 0]},
    }
    region = {"from": "region", "regions": ["*"], "pose": True}
    scenes = [
        {"kind": "table", "name": "one", "weight": 1, "scale": 0.9, "objects": 2, "meshes": 0, "start": region},
        {"kind": "shelf", "scale": 0.9, "levels": 2, "objects": 2, "meshes": 0, "goal": region},
        {"kind": "bin", "scale": 0.9, "bins": 2, "objects": 2, "meshes": 0},
        {"kind": "cage", "scale": 0.9, "bars": 3},
        {"kind": "clutter", "scale": 0.9, "objects": 2, "meshes": 0},
        {
            **{"kind": "variations", "scene": "scene.json", "request": "request.yaml", "moved": ["*"]},
            **{"shift": 0.05, "turn": 0.1, "object_shift": 0.03, "object_turn": 0.3},
        },
        {"kind": "function", "function": "whole_scenes:f", "parameters": {"x": 1}},
    ]
    return {
        **{"count": 3, "records_per_shard": 2, "seed": 0, "robots": [robot], "scenes": scenes, "clearance": 0.005},
        **{"planner": {"planner_id": "auto", "time_limit": 60.0, "sample_period": 0.02}, "tries": 20, "skip": [1]},
        **{"start": {"from": "states", "states": ["ready"], "pose": False}, "goal": {"from": "configuration"}},
    }


def an_object(**changes):
    return {"name": "a", "pose": [0.6, 0, 0.1, 0, 0, 0, 1], **changes}


A_REQUEST = """
start_state:
  joint_state:
    name: [{names}]
    position: [{zeros}]
goal_constraints:
  - joint_constraints: [{goals}]
""".format(
    names=", ".join(f"arm7_joint{k}" for k in range(1, 8)),
    zeros=", ".join(["0.1"] * 7),
    goals=", ".join(f"{{joint_name: arm7_joint{k}, position: 0.2}}" for k in range(1, 8)),
)


def places_in(value, path=()):
    """Every field of a spec, and every mapping that must not have others."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield (*path, key)
        yield from places_in(inner, (*path, key))


def with_value(value, path, new):
    """A copy with another value at a path."""
    if not path:
        return new
    copy = value.copy()
    copy[path[0]] = with_value(value[path[0]] if len(path) > 1 else None, path[1:], new)
    return copy


def name_of(path):
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path).lstrip(".")


def test_every_field_is_refused_when_it_is_wrong(tmp_path, monkeypatch):
    """By one sentence that names it; NaN is nothing that any field may be. And every mapping knows its fields."""
    monkeypatch.chdir(tmp_path)
    spec = whole_spec(tmp_path)
    read_spec(spec)
    places = [path for path in places_in(spec) if "package_dirs" not in path[:-1]]
    assert {"count", "robots[0].base.rpy", "scenes[5].object_turn", "start.states[0]"} <= set(map(name_of, places))
    for path in places:
        with pytest.raises(srmp.Error) as caught:
            generate(with_value(spec, path, float("nan")), tmp_path / "set", workers=1)
        sentence = str(caught.value)
        names = [f"{name_of(path)} is nan; it must be "]
        if isinstance(path[-1], int) or "parameters" in path[:-1]:  # a list of numbers or names is one field
            names.append(f"{name_of(path[:-1])} is ")
        if "planner" in path[:-1]:
            names.append(f"planner: option '{path[-1]}' ")
        assert sentence.startswith(tuple(names)), (names, sentence)
        assert "\n" not in sentence
    for path in [(), *places]:
        inner = spec
        for key in path:
            inner = inner[key]
        if isinstance(inner, dict) and path[-1:] not in (("fixed_joints",), ("parameters",)):
            with pytest.raises(srmp.Error, match=r"unknown|has no option"):
                generate(with_value(spec, path, {**inner, "colour": 1}), tmp_path / "set", workers=1)
    assert not (tmp_path / "set").exists()


def test_rows_are_at_least_a_millisecond_apart(tmp_path):
    with pytest.raises(srmp.InvalidArgument, match=r"planner.sample_period is 1e-09 s; .* at least 0.001 s"):
        generate(spec_of(planner={"sample_period": 1e-9}), tmp_path / "set", workers=1)
    assert not (tmp_path / "set").exists()


def test_a_key_that_appears_twice_is_refused(tmp_path):
    (tmp_path / "spec.yaml").write_text("count: 2\nrobots: [{name: a, model: arm7}]\ncount: 3\n")
    with pytest.raises(srmp.InvalidArgument, match=r"spec\.yaml: the key 'count' appears twice, again in line 3"):
        read_spec(tmp_path / "spec.yaml")


def test_anchors_may_be_merged(tmp_path):
    text = """
count: &count 2
robots: [&first {name: a, model: arm7}, {<<: *first, name: b}]
scenes: [{kind: table}]
seed: *count
"""
    (tmp_path / "spec.yaml").write_text(text)
    spec = read_spec(tmp_path / "spec.yaml")
    assert [robot.name for robot in spec.robots] == ["a", "b"]
    assert (spec.count, spec.seed) == (2, 2)


def test_every_documented_field_is_in_the_whole_spec(tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "datasets.md").read_text()
    rows = re.findall(r"^\| (`.*?) \|", text.split("| field | default | meaning |")[1].split("\n\n")[0], re.MULTILINE)
    documented = [name.split(".")[-1].removesuffix("[]") for row in rows for name in re.findall(r"`([\w.\[\]]+)`", row)]
    kinds = text.split("| kind | scene | parameters (default) |")[1].split("\n\n")[0]
    for row in kinds.splitlines()[2:]:
        documented += re.findall(r"`(\w+)`", row.split("|")[3])
    assert len(documented) > 40
    spec = whole_spec(tmp_path)
    fields = {path[-1] for path in places_in(spec)} | {"model"}  # instead of urdf; it is among the broken ones above
    assert not set(documented) - fields


OBJECTS = [
    ([3], "is not a scene file"),
    ([an_object(pose="x")], "could not convert string to float"),
    ([an_object(pose=[0, 0])], "pose quaternion must be 4 numbers"),
    ([an_object(pose=[0] * 7)], "pose quaternion is zero"),
    ([an_object(shape={"kind": "box", "size": [1]})], "size of box 'a' must be 3 numbers"),
    ([an_object(shape={"kind": "box", "size": [-1, 1, 1]})], "box size of object 'a' is -1"),
    ([an_object(shape={"kind": "box", "size": ["x", 1, 1]})], "could not convert string to float"),
    ([an_object(shape={"kind": [], "size": [1]})], "is not a scene file"),
    ([an_object(), an_object()], "object name 'a' is taken"),
]


@pytest.mark.parametrize(("objects", "sentence"), OBJECTS)
def test_a_broken_scene_of_variations(objects, sentence, tmp_path):
    shape = {"kind": "box", "size": [0.1, 0.1, 0.1]}
    items = [{"shape": shape, **item} if isinstance(item, dict) else item for item in objects]
    (tmp_path / "scene.json").write_text(json.dumps({"scene": {"objects": items}}))
    with pytest.raises(srmp.Error, match=r"scene\.json") as caught:
        read_spec(spec_of(scenes=[{"kind": "variations", "scene": str(tmp_path / "scene.json")}]))
    assert sentence in str(caught.value)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"world: 3", b"world: [", b"", b"world: \x00"])
def test_a_broken_moveit_scene_of_variations(content, tmp_path):
    """Named as the user knows it, and not as the copy that is read."""
    path = tmp_path / "scene.yaml"
    path.write_bytes(content)
    with pytest.raises(srmp.FileError, match=re.escape(str(path))):
        read_spec(spec_of(scenes=[{"kind": "variations", "scene": str(path)}]))


@pytest.mark.parametrize(
    ("content", "sentence"), [("def f(:", "SyntaxError"), ("raise KeyError('x')", "(KeyError: 'x').")]
)
def test_a_module_that_cannot_be_imported(content, sentence, tmp_path, monkeypatch):
    (tmp_path / "torn_module.py").write_text(content)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(srmp.InvalidArgument, match="it must be in a module that can be imported") as caught:
        read_spec(spec_of(scenes=[{"kind": "function", "function": "torn_module:f"}]))
    assert sentence in str(caught.value)


@pytest.mark.parametrize(("key", "content"), [("urdf", "<a/>"), ("urdf", "<robot"), ("srdf", "<robot")])
def test_a_broken_robot_file_is_named_as_the_user_knows_it(key, content, tmp_path):
    path = tmp_path / f"broken.{key}"
    path.write_text(content)
    robot = {"name": "arm", "urdf": srmp.data_path("arm7.urdf"), "end_effector": "arm7_hand", key: str(path)}
    with pytest.raises(srmp.Error, match=re.escape(str(path))):
        read_spec({**spec_of(), "robots": [robot]})


def test_files_that_are_no_specs(tmp_path):
    (tmp_path / "torn.yaml").write_text("count: [1,")
    with pytest.raises(srmp.FileError, match="is not YAML"):
        read_spec(tmp_path / "torn.yaml")
    with pytest.raises(srmp.FileError, match="cannot be read"):
        read_spec(tmp_path / "none.yaml")
    (tmp_path / "list.yaml").write_text("- 1")
    with pytest.raises(srmp.InvalidArgument, match="the spec is"):
        read_spec(tmp_path / "list.yaml")
    with pytest.raises(srmp.InvalidArgument, match="workers 0"):
        generate(spec_of(), tmp_path / "set", workers=0)


def test_scenes_refuse_what_is_wrong():
    scene = Scene()
    with pytest.raises(srmp.InvalidArgument, match="the size of box 'a' is"):
        scene.box("a", [1, 2], [0, 0, 0])
    with pytest.raises(srmp.InvalidArgument, match=r"'donw', did you mean 'down'\?"):
        scene.region("r", [0, 0, 0], [0, 0, 0], "donw")
    with pytest.raises(srmp.InvalidArgument, match="below 0"):
        scene.region("r", [0, 0, -1], [0, 0, 0])
