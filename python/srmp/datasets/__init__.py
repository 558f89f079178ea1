"""Data sets of certified motions: made from a spec, repeatable byte for byte, audited (docs/datasets.md)."""

from srmp.datasets.audit import Audit as Audit
from srmp.datasets.audit import Fault as Fault
from srmp.datasets.audit import audit as audit
from srmp.datasets.dataset import Dataset as Dataset
from srmp.datasets.dataset import Record as Record
from srmp.datasets.dataset import open as open
from srmp.datasets.exporters import export as export
from srmp.datasets.generation import Generated as Generated
from srmp.datasets.generation import generate as generate
from srmp.datasets.scene import Scene as Scene
from srmp.datasets.scene import SceneObject as SceneObject
from srmp.datasets.spec import Spec as Spec
from srmp.datasets.spec import read_spec as read_spec
