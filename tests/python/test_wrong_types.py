"""Wrong types, missing and unknown arguments: one sentence of ours for every function of the library."""

import inspect
import re

import numpy as np
import pytest

import srmp
from srmp import _srmp

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
