"""Data sets of certified motions: made from a spec, repeatable byte for byte, checked independently (docs/datasets.md)."""

from srmp.datasets.generation import Generated as Generated
from srmp.datasets.generation import generate as generate
from srmp.datasets.scene import Scene as Scene
from srmp.datasets.scene import SceneObject as SceneObject
from srmp.datasets.spec import Spec as Spec
from srmp.datasets.spec import read_spec as read_spec
