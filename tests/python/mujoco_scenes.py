"""Small scenes of MuJoCo, and a planner that has read one."""

from pathlib import Path

import mujoco

import srmp


def arm7_spec():
    urdf = Path(srmp.data_path("arm7.urdf")).read_text()
    urdf = urdf.replace('<robot name="arm7">', '<robot name="arm7"><mujoco><compiler fusestatic="false"/></mujoco>')
    return mujoco.MjSpec.from_string(urdf)


def small_scene(actuators=()):
    """The package's own arm, a box and a loose cube; the arm's joints with these actuators."""
    spec = mujoco.MjSpec()
    box = mujoco.mjtGeom.mjGEOM_BOX
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], pos=[0, 0, -0.001])
    spec.worldbody.add_body(name="post", pos=[0.4, 0.4, 0.3]).add_geom(type=box, size=[0.05, 0.05, 0.3])
    cube = spec.worldbody.add_body(name="cube", pos=[0.4, -0.4, 0.03])
    cube.add_freejoint()
    cube.add_geom(type=box, size=[0.03] * 3)
    spec.attach(arm7_spec(), prefix="arm/", frame=spec.worldbody.add_frame())
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST  # stiff servos on light links
    for number, actuator in enumerate(actuators, start=1):
        added = spec.add_actuator(
            name=f"a{number}", target=f"arm/arm7_joint{number}", trntype=mujoco.mjtTrn.mjTRN_JOINT
        )
        actuator(added)
    return spec


def read(spec, **options):
    model = spec.compile()
    data = mujoco.MjData(model)
    planner = srmp.PlannerInterface()
    options.setdefault("articulations", ["arm"])
    return planner, planner.read_sim((model, data), "mujoco", **options), model, data
