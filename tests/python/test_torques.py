"""Torque limits: motions need no more torque than the joints have, in gravity, with what the robot carries."""

import numpy as np
import pinocchio as pin
import pytest
from support import needs_example_robot_data

import srmp
from srmp import FaultKind, MotionLimits, Payload

pytestmark = needs_example_robot_data  # the Panda

WEAK = [40.0, 50.0, 40.0, 40.0, 8.0, 6.0, 4.0]  # [N m]: the Panda's own are 87 and 12
START = np.array([0.0, 0.3, 0.0, -2.0, 0.0, 1.8, 0.7])
GOAL = np.array([1.5, 0.2, 0.3, -1.8, 0.5, 2.2, -0.5])
LOAD = Payload(1.5, center_of_mass=[0.0, 0.02, 0.12], inertia=[0.01, 0.01, 0.005], link="panda_hand")


@pytest.fixture
def panda():
    planner = srmp.PlannerInterface()
    planner.add_robot("panda")
    planner.set_joint_positions("panda", {"panda_finger_joint1": 0.0})  # where Pinocchio has them
    return planner


def needed(trajectory, payload=None, base=None):
    """(n, 7) torques at 1 kHz by Pinocchio's own package, from the URDF."""
    model = pin.buildModelFromUrdf(srmp.robots.find("panda").urdf_path)
    if payload:
        frame = model.frames[model.getFrameId(payload.link)]
        inertia = pin.Inertia(payload.mass, payload.center_of_mass, np.diag(payload.inertia))
        model.appendBodyToJoint(frame.parentJoint, inertia, frame.placement)
    if base is not None:
        model.gravity.linear = base.matrix()[:3, :3].T @ [0, 0, -9.81]
    data = model.createData()
    index = [model.joints[model.getJointId(name)].idx_q for name in trajectory.joint_names]
    torques = []
    for state in zip(*trajectory.state(np.arange(0, trajectory.duration, 0.001))[:3], strict=True):
        full = np.zeros((3, model.nq))
        full[0] = pin.neutral(model)
        full[:, index] = state
        torques.append(pin.rnea(model, data, *full)[index])
    return np.array(torques)


def free_goals(planner, count):
    """Random free configurations."""
    rng = np.random.default_rng(3)
    lower, upper = np.array(planner.get_joint_limits("panda"))[:, :2].T
    found = []
    while len(found) < count:
        q = lower + (upper - lower) * rng.uniform(0.15, 0.85, 7)
        if not planner.is_state_colliding("panda", q):
            found.append(q)
    return found


@pytest.mark.parametrize("timing", ["toppra", "ruckig"])
@pytest.mark.parametrize("payload", [None, LOAD], ids=["empty", "loaded"])
def test_torques_are_kept_by_independent_dynamics(panda, timing, payload):
    panda.set_motion_limits("panda", torque=WEAK, payload=payload if payload else 0)
    panda.make_planner("panda", {"planner_id": "auto", "timing": timing})
    at, solved, largest = START, 0, 0.0
    for goal in free_goals(panda, 12):
        try:
            motion = panda.plan("panda", at, goal)
        except srmp.PlanningError as error:
            assert "hold the robot there at rest" in str(error)
            continue
        use = (np.abs(needed(motion, payload)) / WEAK).max()
        assert use <= 1.0
        assert use <= motion.certificate.torque.fraction + 1e-9
        assert motion.certificate.torque.fraction <= max(1.0 + 1e-6, 1.002 * use)
        assert motion.certificate.holds
        largest = max(largest, use)
        solved, at = solved + 1, motion.positions[-1]
    assert solved >= 5
    assert largest > 0.9  # slow enough, and no slower


def test_the_proof_is_above_every_sample(panda):
    panda.set_motion_limits("panda", torque=[1e4] * 7)
    at = START
    for goal in free_goals(panda, 8):
        motion = panda.plan("panda", at, goal)
        limits = panda.motion_limits("panda")
        for joint in range(7):
            alone = np.full(7, np.inf)
            alone[joint] = 10.0
            checked = MotionLimits(limits.velocity, limits.acceleration, limits.jerk, torque=alone)
            certificate = panda.verify("panda", motion, limits=checked)
            sampled = np.abs(needed(motion))[:, joint].max() / 10.0
            assert sampled - 1e-9 <= certificate.torque.fraction <= max(1.01 * sampled, sampled + 0.01)
        at = goal


def test_a_base_on_a_wall_feels_gravity_elsewhere(panda):
    base = srmp.Pose.from_rpy([0, 0, 0], [np.pi / 2, 0, 0])
    panda.set_base_pose("panda", base)
    panda.set_motion_limits("panda", torque="urdf")
    motion = panda.plan("panda", START, GOAL)
    use = (np.abs(needed(motion, base=base)) / [87, 87, 87, 87, 12, 12, 12]).max()
    assert use == pytest.approx(motion.certificate.torque.fraction, rel=0.01)


def test_without_torques_nothing_changes_and_loads_make_motions_slower(panda):
    before = panda.plan("panda", START, GOAL)
    panda.set_motion_limits("panda", torque=1e6)
    assert np.array_equal(panda.plan("panda", START, GOAL).positions, before.positions)
    panda.set_motion_limits("panda", torque=WEAK)
    empty = panda.plan("panda", START, GOAL)
    panda.set_motion_limits("panda", payload=LOAD)
    loaded = panda.plan("panda", START, GOAL)
    assert before.duration <= empty.duration < loaded.duration
    panda.set_motion_limits("panda", torque={}, payload=0)
    limits = panda.motion_limits("panda")
    assert limits.torque is None
    assert limits.payload is None
    assert panda.plan("panda", START, GOAL) == before


def test_what_cannot_be_held_is_said(panda):
    panda.set_motion_limits("panda", torque={"panda_joint2": 32.0})
    out = np.array([0.0, 1.2, 0.0, -0.3, 0.0, 1.5, 0.0])
    with pytest.raises(
        srmp.PlanningError, match=r"panda_joint2 needs .* of its torque limit to hold the robot there at rest"
    ) as error:
        panda.plan("panda", [0, 0, 0, -1.5, 0, 1.5, 0], out)
    assert error.value.status == srmp.Status.goal_invalid
    with pytest.raises(srmp.PlanningError, match="panda_joint2 needs") as error:
        panda.plan("panda", out, [0, 0, 0, -1.5, 0, 1.5, 0])
    assert error.value.status == srmp.Status.start_invalid


def test_arms_swing_through_where_they_can_be_held(panda):
    """The straight motion passes the arm stretched out, which joint 2 cannot hold."""
    up, down = np.array([0, -0.6, 0, -0.9, 0, 0.4, 0]), np.array([0, 1.2, 0, -2.6, 0, 2.6, 0])
    free = panda.plan("panda", up, down)
    assert np.abs(needed(free)[:, 1]).max() > 36
    panda.set_motion_limits("panda", torque={"panda_joint2": 30.0})
    motion = panda.plan("panda", up, down)
    assert motion.certificate.holds
    assert np.abs(needed(motion)[:, 1]).max() <= 30


def test_two_robots_keep_theirs(panda):
    panda.add_robot("panda", name="other", base_pose=srmp.Pose(p=[1.0, 0.0, 0.0]))
    panda.make_planner(["panda", "other"], {"planner_id": "auto"})
    panda.set_motion_limits("panda", torque=WEAK)
    starts, goals = {"panda": START, "other": START}, {"panda": GOAL, "other": START}
    motions = panda.plan_multi(starts, goals)
    assert (np.abs(needed(motions["panda"])) <= WEAK).all()
    assert motions["panda"].certificate.torque.fraction <= 1 + 1e-6


def test_faults_files_and_forms(panda, tmp_path):
    motion = panda.plan("panda", START, GOAL)
    limits = panda.motion_limits("panda")
    weak = MotionLimits(limits.velocity, limits.acceleration, limits.jerk, torque=WEAK, payload=LOAD)
    certificate = panda.verify("panda", motion, limits=weak)
    (fault,) = certificate.faults
    assert fault.kind == FaultKind.torque_limit
    assert "times its limit" in fault.text
    assert "torques" in certificate.report()
    panda.set_motion_limits("panda", torque=WEAK, payload=LOAD)
    slow = panda.plan("panda", START, GOAL)
    slow.save(tmp_path / "plan.json")
    assert srmp.Trajectory.load(tmp_path / "plan.json").certificate.torque == slow.certificate.torque
    panda.save(tmp_path / "problem.json")
    again = srmp.PlannerInterface.load(tmp_path / "problem.json").motion_limits("panda")
    assert again.payload == LOAD
    np.testing.assert_array_equal(again.torque, WEAK)
    assert "torque" in slow.certificate.to_dict()
    assert "torque" not in motion.certificate.to_dict()
    even = slow.resample(0.01, panda.motion_limits("panda"))
    assert even.certificate.torque.fraction <= 1 + 1e-6
    assert repr(LOAD) == "Payload(1.5 kg on 'panda_hand')"


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"torque": [1, 2]}, "torque limits: got 2, but there are 7 joints"),
        ({"torque": -1}, "panda_joint1: the torque limit is -1; it must be from"),
        ({"torque": np.nan}, "panda_joint1: the torque limit is NaN"),
        ({"torque": {"panda_joint9": 3}}, "torque limits name 'panda_joint9', which is no planned joint"),
        ({"torque": "effort"}, "torque limits are 'effort'; as a text, only 'urdf' is known"),
        ({"payload": -1}, "the payload's mass is -1 kg; it must be above 0 and finite"),
        ({"payload": "box"}, "payload must be a Payload or a mass"),
        ({"torque": 10, "payload": Payload(1, link="panda_hnd")}, "no link 'panda_hnd', did you mean 'panda_hand'"),
    ],
)
def test_bad_limits_are_refused_and_change_nothing(panda, arguments, text):
    before = panda.motion_limits("panda")
    with pytest.raises(srmp.InvalidArgument) as error:
        panda.set_motion_limits("panda", **arguments)
    assert text in str(error.value)
    assert panda.motion_limits("panda") == before


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"mass": 0}, "the payload's mass is 0 kg"),
        ({"mass": 1, "center_of_mass": [0, np.nan, 0]}, "center of mass must be three finite numbers"),
        ({"mass": 1, "inertia": [-1, 0, 0]}, "inertia must be three finite numbers, 0 or above"),
    ],
)
def test_bad_payloads_are_refused(arguments, text):
    with pytest.raises(srmp.InvalidArgument, match=text):
        Payload(**arguments)


def test_a_robot_without_masses_is_refused():
    planner = srmp.PlannerInterface()
    planner.add_robot("arm7")
    with pytest.raises(srmp.InvalidArgument, match="no link of its URDF has an <inertial> with a mass"):
        planner.set_motion_limits("arm7", torque=10)
