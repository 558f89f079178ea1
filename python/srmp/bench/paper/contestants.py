"""The planners that the experiments compare."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType

from srmp.bench import ompl_wheel

BENCHMARK = "the paper's experiments"
"""What result files are called."""
SRMP, OMPL, COAL, MOVEIT = "SRMP", "OMPL", "OMPL, plain Coal", "MoveIt"
"""Whose planner it is, and what checks collisions: our checker for the first two, Coal alone for the third."""
NO_OMPL = (
    "OMPL's planners were not run: install libompl-dev and build with -DSRMP_BUILD_BENCH=ON -DSRMP_BUILD_PYTHON=ON."
)
"""What a benchmark says where ompl_module() is None."""


@dataclass(frozen=True)
class Contestant:
    """A planner of an experiment, under the name that the tables have."""

    name: str
    library: str
    planner: str = ""
    """Its id in the library; by default its name."""
    search: bool = False
    """Whether it is one of the search-based planners that the paper compares with OMPL's."""
    anytime: bool = False
    """Whether it improves its path until the time is over."""

    @property
    def id(self) -> str:
        """What the library calls it."""
        return self.planner or self.name

    def among(self, names: Sequence[str]) -> bool:
        """Whether it is meant by one of the names, or ids; by none: everyone is."""
        return not names or self.name in names or self.id in names

    @property
    def key(self) -> str:
        """Its name in the names of rows; one of an experiment."""
        return f"{self.library}/{self.name}"


@dataclass(frozen=True)
class Experiment:
    """One of the paper's experiments: what is planned by whom, and the defaults of its size."""

    letter: str
    title: str
    contestants: tuple[Contestant, ...]
    time_limit: float
    problems: str
    repetitions: int = 1


_W, _MH = Contestant("wA*", SRMP, "wAstar", search=True), Contestant("MHA*", SRMP, "MHAstar", search=True)
_PASE = Contestant("wPA*SE", SRMP, "wPASE", search=True)
_ARA = Contestant("ARA*", SRMP, "ARAstar", search=True, anytime=True)
_AMRA = Contestant("AMRA*", SRMP, "AMRAstar", anytime=True)
_AUTO = Contestant("auto", SRMP)
_OF_WHEEL = "AORRTC"
_ANYTIME = ("RRT*", _OF_WHEEL)


def _of_ompl(*names: str, library: str = OMPL) -> tuple[Contestant, ...]:
    return tuple(Contestant(name, library, anytime=name in _ANYTIME) for name in names)


_SINGLE = ("RRT-Connect", "BiTRRT", "BiEST", "PRM", "RRT*", "AORRTC")

EXPERIMENTS = {
    experiment.letter: experiment
    for experiment in (
        Experiment(
            "a",
            "Consistency of one arm",
            (
                *(_W, _MH, _PASE, _ARA, _AMRA, _AUTO),
                *_of_ompl(*_SINGLE),
                *_of_ompl(*_SINGLE, library=COAL),
                *(Contestant(name, MOVEIT) for name in ("CHOMP", "STOMP")),
            ),
            time_limit=5.0,
            problems="1-15",
            repetitions=10,
        ),
        Experiment(
            "b",
            "Several arms",
            (Contestant("xECBS", SRMP, search=True), _AUTO, *_of_ompl("BiTRRT", "PRM", "RRT-Connect")),
            time_limit=20.0,
            problems="1-15",
            repetitions=5,
        ),
        Experiment(
            "c",
            "MotionBenchMaker",
            (
                *(_W, _MH, _ARA, _PASE, _AUTO),
                *_of_ompl("RRT-Connect", "BiEST", "RRT*"),
                *_of_ompl("RRT-Connect", "BiEST", "RRT*", library=COAL),
            ),
            time_limit=10.0,
            problems="1-10",
        ),
    )
}


def ompl_module() -> ModuleType | None:
    """The module with OMPL's planners; None where it was not built."""
    try:
        from srmp import _srmp_ompl
    except ImportError:
        return None
    return _srmp_ompl


def by_wheel(contestant: Contestant) -> bool:
    """Whether the `ompl` wheel runs it: AORRTC, which OMPL has since version 2, where the module is of an older one."""
    if contestant.library != OMPL or contestant.id != _OF_WHEEL:
        return False
    module = ompl_module()
    return ompl_wheel.has(_OF_WHEEL) and not (module and _OF_WHEEL in module.planners)


def why_not_run(contestant: Contestant) -> str:
    """Why a contestant cannot be run here; empty where it can."""
    if contestant.library == MOVEIT:
        return "not run"
    if contestant.library == SRMP or by_wheel(contestant):
        return ""
    if (module := ompl_module()) is None:
        return "no OMPL"
    return "" if contestant.id in module.planners else "not in this OMPL"
