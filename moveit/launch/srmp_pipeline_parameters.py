"""MoveIt 2: the parameters of move_group for the pipeline "srmp", for a launch file.

from srmp_pipeline_parameters import srmp_pipeline
parameters = moveit_config.to_dict() | srmp_pipeline("panda")
"""

import os
from pathlib import Path

import yaml
from ament_index_python.packages import get_package_share_directory

ONE_PLUGIN = ("humble", "iron")
"""ROS distributions whose pipelines read one plugin, and adapters as one text; later ones read lists."""


def srmp_pipeline(robot: str, default: bool = True, distribution: str = os.environ.get("ROS_DISTRO", "")) -> dict:
    """Parameters that add the pipeline.

    default: requests that name no pipeline go to it. distribution: of ROS 2, which decides how they are written.
    """
    name = "srmp_planning_humble.yaml" if distribution in ONE_PLUGIN else "srmp_planning_ros2.yaml"
    file = Path(get_package_share_directory("srmp_moveit")) / "config" / robot / name
    parameters = {"planning_pipelines": ["srmp"], "srmp": yaml.safe_load(file.read_text())}
    return parameters | ({"default_planning_pipeline": "srmp"} if default else {})
