"""Wrong types, missing and unknown arguments: one sentence of ours for every function of the library."""

import inspect
import re
import subprocess
import sys

import numpy as np
import pytest

import srmp
from srmp import _srmp
from srmp.compat import mplib

CALLS = [
    (lambda p: p.add_box(7, [1, 1, 1]), "add_box: name must be a string, but is 7"),
    (lambda p: p.add_box("b", [1, 1, 1], padding="thick"), "add_box: padding must be a number, but is 'thick'"),
    (
        lambda p: p.add_box("b", [1, 1, 1], srmp.Pose(), 0.0, 5),
        "add_box takes at most 4 arguments without a name, but got 5",
    ),
    (lambda p: p.add_box("b"), "add_box needs 'size'"),
    (lambda p: p.add_box("b", siez=[1, 1, 1]), "add_box has no argument 'siez', did you mean 'size'?"),
    (lambda p: p.add_box("b", size=[1, 1, 1], pose=[0, 0, 1]), r"add_box: pose must be a Pose, but is \[0, 0, 1\]"),
    (lambda p: p.plan("arm", np.zeros(7)), "start.* must be numbers, but is 'arm'"),
    (lambda p: p.plan(np.zeros(7)), "plan needs"),
    (
        lambda p: p.plan("arm", np.zeros(7), "ready", planning_time=5),
        "plan has no argument 'planning_time'; it is 'time_limit' here",
    ),
    (lambda p: p.add_articulation(urdf_path=7), "add_articulation: urdf_path must be a string"),
    (
        lambda p: p.add_articulation(joint_names=[1, 2]),
        r"joint_names must be a list \(a string each\), but is \[1, 2\]",
    ),
    (lambda p: p.set_joint_positions("arm", {"a": "b"}), r"positions must be a dictionary \(a number by string\)"),
    (lambda p: p.set_base_pose("arm", None), "set_base_pose: pose must be a Pose, but is None"),
    (lambda p: p.collision_checker("arm", 7), "collision_checker: "),
    (lambda p: p.make_planner("arm"), "make_planner needs 'options'"),
    (
        lambda p: p.make_planner("arm", {"planner_id": "auto", "time_limit": [1]}),
        r"option 'time_limit' must be text or a list of texts, but is \[1\]",
    ),
    (lambda p: p.make_planner("arm", {"planner_id": [None]}), r"option 'planner_id' must be .*, but is \[None\]"),
    (lambda p: p.plan_many(7), r"plan_many: requests must be a list \(a PlanRequest each\), but is 7"),
    (lambda p: srmp.Pose(p=[0, 0, 0], qq=[0, 0, 0, 1]), "Pose has no argument 'qq'"),
    (lambda p: srmp.GoalConstraint("POSE", srmp.Pose()), "GoalConstraint: type must be a GoalType, but is 'POSE'"),
    (lambda p: srmp.GoalConstraint(), "GoalConstraint needs 'type' and 'targets'"),
    (lambda p: srmp.planner_info(3), "planner_info: planner_id must be a string, but is 3"),
    (lambda p: srmp.PlannerInterface(3), "PlannerInterface"),
]


@pytest.mark.parametrize(("call", "sentence"), CALLS)
def test_wrong_arguments_are_named(arm, call, sentence):
    with pytest.raises(srmp.InvalidArgument, match=sentence) as error:
        call(arm)
    text = str(error.value)
    assert "\n" not in text and len(text) < 500


def test_it_is_a_type_error_too(arm):
    with pytest.raises(TypeError) as error:
        arm.add_box(7, [1, 1, 1])
    assert isinstance(error.value, srmp.WrongType)
    assert isinstance(error.value, srmp.Error)


class Odd:
    """No function of the library takes one."""

    def __repr__(self):
        return "an\nodd " + 300 * "x"


def functions():
    for name, value in vars(_srmp).items():
        if type(value).__name__ == "nb_func" and not name.startswith("__"):
            yield name, value, 0
        elif inspect.isclass(value) and type(value).__name__.startswith("nb_type"):
            for method, member in vars(value).items():
                if type(member).__name__ == "nb_method" and (method == "__init__" or not method.startswith("__")):
                    yield f"{name}.{method}", member, 1


FUNCTIONS = {name: (function, methods) for name, function, methods in functions()}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_says_it_in_one_sentence(name):
    """With one argument more than it has, and with an unknown one."""
    function, is_method = FUNCTIONS[name]
    instance = [Odd()] * is_method
    for args, keywords in (([Odd()] * 30, {}), ([], {"no_such_argument": Odd()})):
        with pytest.raises(srmp.WrongType) as error:
            function(*instance, *args, **keywords)
        text = str(error.value)
        assert "\n" not in text and len(text) < 500
        assert "incompatible function arguments" not in text


# --- functions in Python


BAD = {"None": None, "object": object(), "long": "x" * 10**6, "lines": "a\nb\u2028c\x85d", "no UTF-8": "a\udc80b"}
PATH = srmp.Trajectory(["a"], [[0.0], [1.0]], [0.0, 1.0])


def missing(bad):
    """Where it is a text, in a directory that does not exist: any text may be the name of a file."""
    return f"missing/{bad}" if isinstance(bad, str) else bad


IN_PYTHON = {
    "data_path": lambda p, bad: srmp.data_path(bad),
    "verify: scene": lambda p, bad: srmp.verify(bad, PATH),
    "verify: trajectory": lambda p, bad: srmp.verify(p, bad),
    "verify: package_dirs": lambda p, bad: srmp.verify("scene.json", PATH, package_dirs=bad),
    "add_robot": lambda p, bad: p.add_robot(bad),
    "add_robot: keyword": lambda p, bad: p.add_robot("arm7", **{str(bad): 1}),
    "register": lambda p, bad: srmp.robots.register(bad),
    "find": lambda p, bad: srmp.robots.find(bad),
    "sample_allowed_collisions": lambda p, bad: srmp.robots.sample_allowed_collisions(bad),
    "sample_allowed_collisions: end_effector": lambda p, bad: srmp.robots.sample_allowed_collisions(
        srmp.data_path("arm7.urdf"), samples=1, end_effector=bad
    ),
    "options: no name": lambda p, bad: srmp.Auto(bad),
    "options: name": lambda p, bad: srmp.Auto(**{str(bad): 1}),
    "options: value": lambda p, bad: p.make_planner("arm", srmp.Auto(weight=bad)),
    "options: robots": lambda p, bad: p.make_planner("arm", srmp.Auto(robots=bad)),
    "BatchPlanner": lambda p, bad: srmp.BatchPlanner(bad),
    "BatchPlanner: a scene": lambda p, bad: srmp.BatchPlanner([bad]),
    "BatchPlanner: robot": lambda p, bad: srmp.BatchPlanner([p], bad),
    "BatchPlanner: options": lambda p, bad: srmp.BatchPlanner([p], options=bad),
    "BatchPlanner: threads": lambda p, bad: srmp.BatchPlanner([p], threads=bad),
    "update: scene": lambda p, bad: srmp.BatchPlanner([p]).update(bad, {}),
    "update: poses": lambda p, bad: srmp.BatchPlanner([p]).update(0, bad),
    "update: object": lambda p, bad: srmp.BatchPlanner([p]).update(0, {bad: srmp.Pose()}),
    "plan: starts": lambda p, bad: srmp.BatchPlanner([p]).plan(bad, [bad]),
    "plan: goals": lambda p, bad: srmp.BatchPlanner([p]).plan([np.zeros(7)], bad),
    "from_dict": lambda p, bad: srmp.Trajectory.from_dict(bad),
    "from_dict: key": lambda p, bad: srmp.Trajectory.from_dict({bad: 1}),
    "from_dict: positions": lambda p, bad: srmp.Trajectory.from_dict({"joint_names": ["a"], "positions": bad}),
    "from_csv": lambda p, bad: srmp.Trajectory.from_csv(bad),
    "to_csv": lambda p, bad: PATH.to_csv(missing(bad)),
    "to_ros": lambda p, bad: PATH.to_ros(bad),
    "from_joint_trajectory": lambda p, bad: srmp.Trajectory.from_joint_trajectory(bad),
    "from_joint_trajectory: points": lambda p, bad: srmp.Trajectory.from_joint_trajectory(
        {"joint_names": ["a"], "points": bad}
    ),
    "Trajectory.plot: path": lambda p, bad: PATH.plot(missing(bad)),
    "Trajectory.plot: limits": lambda p, bad: PATH.plot(None, bad),
    "MultiTrajectory.plot": lambda p, bad: srmp.MultiTrajectory({"arm": PATH}).plot(missing(bad)),
    "to_html": lambda p, bad: p.to_html(None, bad),
    "to_html: kinds": lambda p, bad: p.to_html(kinds=[bad]),
    "to_html: robot": lambda p, bad: p.to_html(None, {bad: PATH}),
    "plot": lambda p, bad: p.plot(missing(bad)),
    "SearchTrace.plot": lambda p, bad: srmp.SearchTrace().plot(bad),
    "SearchTrace.to_html": lambda p, bad: srmp.SearchTrace().to_html(bad),
    "read_sim: kind": lambda p, bad: p.read_sim(None, bad),
    "read_sim: exclude": lambda p, bad: p.read_sim(None, "mujoco", exclude=bad),
    "mplib.Planner: urdf": lambda p, bad: mplib.Planner(bad, "arm7_hand"),
    "mplib.Planner: move_group": lambda p, bad: mplib.Planner(srmp.data_path("arm7.urdf"), bad),
    "mplib.Planner: keyword": lambda p, bad: mplib.Planner(srmp.data_path("arm7.urdf"), **{str(bad): 1}),
}
NONE_MEANS_DEFAULT = {
    *("BatchPlanner: robot", "BatchPlanner: options", "BatchPlanner: threads", "Trajectory.plot: path"),
    *("Trajectory.plot: limits", "MultiTrajectory.plot", "to_html", "plot"),
}


def require_sentence(text):
    assert len(text.splitlines()) == 1
    assert len(text) < 500
    assert text.encode()
    assert not re.match(r"_[a-z]", text), "the name of a private function"


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("name", IN_PYTHON)
def test_functions_in_python_say_it_in_one_sentence(arm, name, value, tmp_path, monkeypatch):
    if value == "None" and name in NONE_MEANS_DEFAULT:
        pytest.skip("None is the default")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(srmp.Error) as error:
        IN_PYTHON[name](arm, BAD[value])
    require_sentence(str(error.value))


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("argument", ["planner", "trajectory", "kinds", "host", "port"])
def test_viewers_say_it_in_one_sentence(arm, argument, value):
    viewer = pytest.importorskip("srmp.viewer")
    pytest.importorskip("viser")
    if value == "None" and argument in ("trajectory", "kinds"):
        pytest.skip("None is the default")
    for call in (viewer.Viewer, viewer.show):
        with pytest.raises(srmp.Error) as error:
            call(**{"planner": arm, argument: BAD[value]})
        require_sentence(str(error.value))


def test_missing_and_unknown_arguments_of_functions_in_python():
    for call, text in (
        (lambda: srmp.data_path(), "data_path needs 'name'"),
        (lambda: srmp.data_path("arm7.udrf"), r"'arm7\.udrf' is not .*, did you mean 'arm7\.urdf'\?"),
        (lambda: srmp.verify(), "verify needs 'scene' and 'trajectory'"),
        (lambda: srmp.BatchPlanner(), "BatchPlanner needs 'scenes'"),
        (lambda: srmp.BatchPlanner([], thread=1), "BatchPlanner has no argument 'thread', did you mean 'threads'?"),
        (lambda: srmp.WAStar(weigth=3), "WAStar has no argument 'weigth', did you mean 'weight'?"),
        (lambda: srmp.Auto(5), "Auto takes at most 0 arguments without a name, but got 1; 'time_limit', .* by name"),
        (lambda: mplib.Planner(), "Planner.* missing a required argument: 'urdf'"),
    ):
        with pytest.raises(srmp.Error, match=text) as error:
            call()
        require_sentence(str(error.value))


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("a=" + "[" * 10**5, "nested too deeply"),
        ("a=" + "1" * 5000, "is not TOML"),
        ('["a\\nb"]\nurdf = 1', "urdf of robot 'a b' must be a string, but is 1"),
        ('["' + "x" * 5000 + '"]', "needs urdf"),
    ],
)
def test_lists_of_robots_say_it_in_one_sentence(content, text, tmp_path):
    (tmp_path / "list.toml").write_text(content)
    with pytest.raises(srmp.FileError, match=text) as error:
        srmp.robots.register(tmp_path / "list.toml")
    require_sentence(str(error.value))


def test_paths_that_cannot_be_are_refused():
    for path in ("/tmp/" + "x" * 5000, "a\0b"):
        for call in (
            *(srmp.data_path, srmp.robots.register, srmp.robots.sample_allowed_collisions),
            *(srmp.Trajectory.from_csv, srmp.Trajectory.load, PATH.to_csv, PATH.plot),
        ):
            with pytest.raises(srmp.Error) as error:
                call(path)
            require_sentence(str(error.value))


def test_text_that_is_no_utf8_is_called_so(arm):
    with pytest.raises(
        srmp.WrongType, match=r"^remove_object: name has characters that do not exist in UTF-8: '\\udc80'$"
    ):
        arm.remove_object("\udc80")


def test_robots_are_there_without_an_import_of_their_own():
    program = "import srmp, sys; assert 'srmp.robots' not in sys.modules; print(srmp.robots.find('arm7').name)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300)
    assert done.stdout == "arm7\n", done.stderr


def test_errors_of_users_keep_what_is_no_text():
    assert srmp.InvalidArgument(1, "a\nb").args == (1, "a b")
    assert srmp.FileError(2, "a\nb").errno == 2


def test_what_functions_of_the_user_raise_is_theirs(arm):
    def progress(done, total):
        raise TypeError("mine")

    ready = np.array(arm.get_group_states("arm")["ready"])
    with pytest.raises(TypeError, match=r"^mine$") as error:
        arm.plan_many([srmp.PlanRequest("arm", ready + 0.9 * np.eye(7)[0], ready + np.eye(7)[0])], 1, progress)
    assert not isinstance(error.value, srmp.Error)


def test_operators_leave_other_types_to_python():
    with pytest.raises(TypeError, match="unsupported operand"):
        srmp.Pose() * Odd()
    assert srmp.Pose() != Odd()


def test_every_signature_is_understood():
    from srmp._wrong_types import _described, _parameters

    for name, (function, _) in FUNCTIONS.items():
        for signature, *_ in function.__nb_signature__:
            for parameter in _parameters(signature):
                text = _described(parameter.type)
                assert not re.search(r"[\[\]|]", text), f"{name}: {parameter.name}: {text}"


def test_ctrl_c_is_no_wrong_type():
    class Interrupted:
        def __array__(self, *args, **kwargs):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        srmp.Pose(p=Interrupted())


def test_classes_of_options_can_be_derived_from():
    class Quick(srmp.Auto):
        def __init__(self, **options):
            super().__init__(time_limit=0.5, **options)

    assert Quick(weight=3.0).to_dict()["weight"] == 3.0
    assert Quick().time_limit == 0.5


def test_numbers_of_numpy_are_whole_numbers_and_arrays_are_not():
    scene = srmp.PlannerInterface()
    scene.add_robot("arm7", name="arm")
    srmp.BatchPlanner([scene], threads=np.int64(1))
    with pytest.raises(srmp.WrongType, match="threads"):
        srmp.BatchPlanner([scene], threads=np.array([1, 2]))
