"""MoveIt 2: the parameters of move_group for the pipeline "srmp", for a launch file.

from srmp_pipeline_parameters import srmp_pipeline
parameters = moveit_config.to_dict() | srmp_pipeline("panda")
"""

from pathlib import Path

import yaml
from ament_index_python.packages import get_package_share_directory


def srmp_pipeline(robot: str, default: bool = True) -> dict:
    """Parameters that add the pipeline; `default`: requests that name no pipeline go to it."""
    file = Path(get_package_share_directory("srmp_moveit")) / "config" / robot / "srmp_planning_ros2.yaml"
    parameters = {"planning_pipelines": ["srmp"], "srmp": yaml.safe_load(file.read_text())}
    return parameters | ({"default_planning_pipeline": "srmp"} if default else {})
