"""Specs of data sets: read from YAML, checked field by field, and made independent of this machine's paths."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import importlib
import importlib.util
import json
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import srmp
from srmp._files import plain
from srmp.datasets.fields import Fields, short
from srmp.datasets.kinds import KINDS
from srmp.datasets.robot_files import RobotSpec, pack, read_robot

FORMAT = "srmp data set"
FORMAT_VERSION = 1
SOURCES = ("configuration", "region", "states")
TIME_LIMIT = 60.0
"""Of a plan [s], unless the spec says otherwise."""
MAX_EXPANSIONS = 10_000
"""A plan by `auto` ends after so many expanded states, unless the spec says otherwise: about 40 times what the hardest
of 10 000 motions takes. Another number makes other records, and needs another FORMAT_VERSION."""
MAX_GROUP_EXPANSIONS = 1_000_000
"""A plan of robots together ends after so many: 25 times what the hardest of 60 motions of two arms takes."""
_MAX_SHARDS = 10_000_000
_MIN_SAMPLE_PERIOD = 1e-3  # [s]
_NOT_CONTENT = ("count", "records_per_shard", "skip")
"""What a spec says of the data set as a whole, and not of each record."""
_IMPROVING = ("ARAstar", "AMRAstar")
"""Planners that improve a path until the clock stops them."""


@dataclass(frozen=True)
class Sampler:
    """Where starts or goals come from."""

    source: str
    """configuration: anywhere within the joint limits; region: a tool pose in a region of the scene; states: a list."""
    regions: tuple[str, ...] = ()
    """Patterns of names of regions; none: all."""
    states: tuple[Any, ...] = ()
    """Names of states of the SRDF, or configurations."""
    pose: bool = False
    """A goal is the tool's pose, any configuration of which is good, instead of the configuration that was drawn."""


@dataclass(frozen=True)
class SceneSpec:
    """One kind of scenes, and how often it is drawn relative to the others."""

    name: str
    kind: str
    weight: float
    start: Sampler
    goal: Sampler
    parameters: Mapping[str, Any]


@dataclass(frozen=True)
class Spec:
    """What a data set holds. A record is a function of its index and of `content`."""

    count: int
    records_per_shard: int
    seed: int
    robots: tuple[RobotSpec, ...]
    scenes: tuple[SceneSpec, ...]
    planner: Mapping[str, Any]
    """Options but for the time limit."""
    clearance: float
    """Of starts and goals [m]."""
    tries: int
    """Scenes that are drawn for a record before it ends as `no_problem`."""
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    """Files that the data set carries: robots' files and the modules of functions, by relative path."""
    time_limit: float = TIME_LIMIT
    """Of a plan [s]. A record whose plan reaches it is not stored, so that no record depends on the clock."""
    skip: tuple[int, ...] = ()
    """Records that are not planned: those whose plans would take too long."""

    @property
    def shards(self) -> int:
        """How many shards the data set has."""
        return -(-self.count // self.records_per_shard)

    def numbers(self, shard: int) -> range:
        """The indices of the records of a shard."""
        first = shard * self.records_per_shard
        return range(first, min(first + self.records_per_shard, self.count))

    @property
    def options(self) -> dict[str, Any]:
        """All options of the planner that make_planner needs."""
        counted = {"max_expansions": MAX_EXPANSIONS, "max_group_expansions": MAX_GROUP_EXPANSIONS}
        of_auto = counted if self.planner["planner_id"] == "auto" else {}
        return {**of_auto, **self.planner, "time_limit": self.time_limit}

    def content(self) -> dict[str, Any]:
        """What records depend on, without paths of this machine: files stand as hashes."""
        whole = dataclasses.asdict(self)
        for key in (*_NOT_CONTENT, "time_limit", "files"):
            del whole[key]
        hashes = {name: hashlib.sha256(data).hexdigest() for name, data in sorted(self.files.items())}
        return {"format_version": FORMAT_VERSION, **plain(whole), "files": hashes}

    @property
    def identity(self) -> str:
        """The SHA-256 of `content`: 64 hexadecimal digits."""
        return identity_of(self.content())

    def to_dict(self) -> dict[str, Any]:
        """As index.json holds it; from_dict makes it again from that and the files."""
        return {**self.content(), **{key: plain(getattr(self, key)) for key in _NOT_CONTENT}}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], files: Mapping[str, bytes]) -> Spec:
        """The spec that to_dict wrote."""
        scenes = tuple(
            SceneSpec(**{**scene, "start": _sampler_of(scene["start"]), "goal": _sampler_of(scene["goal"])})
            for scene in values["scenes"]
        )
        robots = tuple(RobotSpec(**robot) for robot in values["robots"])
        names = ("count", "records_per_shard", "seed", "planner", "clearance", "tries")
        own = {name: values[name] for name in names}
        return cls(robots=robots, scenes=scenes, files=dict(files), skip=tuple(values["skip"]), **own)


def identity_of(content: Mapping[str, Any]) -> str:
    """The SHA-256 of a spec's content, as Spec.identity."""
    text = json.dumps({key: content[key] for key in sorted(content) if key not in _NOT_CONTENT}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def read_spec(source: str | Path | Mapping[str, Any]) -> Spec:
    """The spec of a YAML file, or of a dictionary laid out like one (relative paths: from the current directory).

    docs/datasets.md lists the fields. Raises FileError for a file that cannot be read, InvalidArgument with the name of
    the field for anything missing, unknown or out of range.
    """
    if isinstance(source, Mapping):
        return _Reader(Path.cwd()).read(source)
    path = Path(source)
    try:
        return _Reader(path.resolve().parent).read(_load_yaml(path))
    except srmp.InvalidArgument as error:
        raise srmp.InvalidArgument(f"{path}: {error}") from error


def _load_yaml(path: Path) -> Any:
    try:
        import yaml
    except ModuleNotFoundError as error:
        raise srmp.Error(
            'specs need PyYAML: pip install ".[datasets]" in a checkout (or pip install pyyaml).'
        ) from error
    try:
        loader = yaml.SafeLoader(path.read_text(encoding="utf-8"))
        node = loader.get_single_node()
        _require_unique_keys(node)
        return None if node is None else loader.construct_document(node)
    except OSError as error:
        raise srmp.FileError(f"{path} cannot be read: {error.strerror}.") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        sentence = " ".join(str(error).split())
        raise srmp.FileError(f"{path} is not YAML: {sentence}.") from error


def _require_unique_keys(root: Any) -> None:
    """Of a tree of nodes: PyYAML takes the last of equal keys."""
    from yaml import MappingNode, ScalarNode

    left, known = [root], set[int]()  # an alias is the node itself
    while left:
        node = left.pop()
        if id(node) in known or node is None or isinstance(node, ScalarNode):
            continue
        known.add(id(node))
        if not isinstance(node, MappingNode):
            left += node.value
            continue
        seen = set[str]()
        for key, value in node.value:
            left.append(value)
            if not isinstance(key, ScalarNode):
                continue
            if key.value in seen:
                line = key.start_mark.line + 1
                raise srmp.InvalidArgument(f"the key '{key.value}' appears twice, again in line {line}.")
            seen.add(key.value)


class _Reader:
    """Reads a spec whose relative paths begin at a directory."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._files: dict[str, bytes] = {}

    def read(self, values: Any) -> Spec:
        fields = Fields(values)
        count = fields.whole("count", least=1)
        per_shard = fields.whole("records_per_shard", 500, least=1, most=100_000)
        if -(-count // per_shard) > _MAX_SHARDS:
            raise fields.refusal("count", count, f"at most {_MAX_SHARDS} times records_per_shard, {per_shard}")
        seed = fields.whole("seed", 0, most=2**63 - 1)
        robots = self._robots(fields)
        start, goal = (self._sampler(fields.inner(key), None, robots) for key in ("start", "goal"))
        self._robots_read = robots
        scenes = tuple(self._scene(item, start, goal) for item in fields.items("scenes"))
        names = [scene.name for scene in scenes]
        for name in names:
            if names.count(name) > 1:
                raise srmp.InvalidArgument(f"two scenes have the name '{name}'; give them different ones with 'name'.")
        planner, time_limit = self._planner(fields, [robot.name for robot in robots])
        clearance = fields.number("clearance", 0.005, least=0.0, most=1.0)
        tries = fields.whole("tries", 20, least=1, most=10_000)
        skip = fields.wholes("skip")
        fields.close()
        return Spec(count, per_shard, seed, robots, scenes, planner, clearance, tries, self._files, time_limit, skip)

    def _robots(self, fields: Fields) -> tuple[RobotSpec, ...]:
        robots, sources = [], []
        for item in fields.items("robots"):
            robot, source = read_robot(item, self._directory)
            if robot.name in [other.name for other in robots]:
                raise srmp.InvalidArgument(f"two robots have the name '{robot.name}'.")
            self._files.update(pack(robot.name, source))
            robots.append(robot)
            sources.append(source)
        with _unpacked(self._files) as directory:  # groups, links and joints must exist
            planner = srmp.PlannerInterface()
            for k, robot in enumerate(robots):
                try:
                    robot.add_to(planner, directory)
                except srmp.Error as error:
                    sentence = sources[k].named_in(str(error), robot.files_in(directory))
                    raise srmp.InvalidArgument(f"robots[{k}]: {sentence}") from error
        self._world = planner
        return tuple(robots)

    def _planner(self, fields: Fields, robots: list[str]) -> tuple[dict[str, Any], float]:
        """The options as given but for the time limit, and the time limit."""
        options = {"planner_id": "auto", "time_limit": TIME_LIMIT, **fields.mapping("planner")}
        for key, value in options.items():  # of one robot too: mprim_path_NAME
            if key.partition("_path")[0] == "mprim" and value:
                raise srmp.InvalidArgument(
                    f"planner.{key} is {short(value)}; in data sets it must be empty: a file of this machine is not "
                    "known to others."
                )
        try:
            known = srmp.planner_options(options)
            self._world.make_planner(robots, options)  # heuristics, and whether the planner plans for so many robots
        except (srmp.Error, OverflowError) as error:
            raise srmp.InvalidArgument(f"planner: {error}") from error
        if known["planner_id"] in _IMPROVING:
            raise srmp.InvalidArgument(
                f"planner.planner_id is '{known['planner_id']}', which improves its path until the clock stops it; in "
                "data sets it must be a planner that does not."
            )
        if len(robots) == 1 and not srmp.planner_info(known["planner_id"]).one_robot:
            raise srmp.InvalidArgument(
                f"planner.planner_id is '{known['planner_id']}', which plans for many robots only; there is one."
            )
        if known["sample_rate"] != 0.0:
            raise srmp.InvalidArgument(
                f"planner.sample_rate is {known['sample_rate']:g}; in data sets rows are a planner.sample_period apart."
            )
        if known["sample_period"] < _MIN_SAMPLE_PERIOD:
            raise srmp.InvalidArgument(
                f"planner.sample_period is {known['sample_period']:g} s; in data sets it must be at least "
                f"{_MIN_SAMPLE_PERIOD:g} s."
            )
        for key, allowed in (("certify", True), ("improve_time", 0.0)):
            if key in known and known[key] != allowed:
                raise srmp.InvalidArgument(f"planner.{key} is {known[key]!r}; in data sets it must be {allowed!r}.")
        if known["timing"] == "none":
            raise srmp.InvalidArgument("planner.timing is 'none'; in data sets it must be 'toppra' or 'ruckig'.")
        del options["time_limit"]
        return plain(options), float(known["time_limit"])

    def _scene(self, fields: Fields, start: Sampler | None, goal: Sampler | None) -> SceneSpec:
        kind = fields.text("kind", choices=tuple(KINDS))
        name = fields.text("name", kind)
        weight = fields.number("weight", 1.0, least=1e-9, most=1e9)
        defaults = {"start": Sampler(KINDS[kind].start), "goal": Sampler(KINDS[kind].goal)}
        if kind == "variations":
            parameters, own = self._variations(fields)
            defaults.update(own)
        elif kind == "function":
            parameters = self._function(fields)
        else:
            parameters = {
                key: fields.whole(key, known.default, int(known.least), known.most)
                if isinstance(known.default, int)
                else fields.number(key, known.default, known.least, known.most)
                for key, known in KINDS[kind].parameters.items()
            }
        robots = self._robots_read
        samplers = {
            "start": self._sampler(fields.inner("start"), start or defaults["start"], robots),
            "goal": self._sampler(fields.inner("goal"), goal or defaults["goal"], robots),
        }
        fields.close()
        return SceneSpec(name, kind, weight, parameters=parameters, **samplers)  # type: ignore[arg-type]

    def _sampler(self, fields: Fields | None, default: Sampler | None, robots: tuple[RobotSpec, ...]) -> Sampler | None:
        if fields is None:
            return default
        source = fields.text("from", choices=SOURCES)
        regions = fields.texts("regions") if source == "region" else ()
        pose = fields.any("pose", False)
        if not isinstance(pose, bool):
            raise fields.refusal("pose", pose, "true or false")
        states = ()
        if source == "states":
            given = fields.any("states", required=True)
            states = tuple(self._state(fields, k, state, robots) for k, state in enumerate(_list(fields, given)))
        fields.close()
        return Sampler(source, regions, states, pose)

    def _state(self, fields: Fields, k: int, state: Any, robots: tuple[RobotSpec, ...]) -> Any:
        for robot in robots:
            if isinstance(state, str) and state not in (known := self._world.get_group_states(robot.name)):
                raise fields.refusal(f"states[{k}]", state, f"a state of '{robot.name}': {', '.join(known) or 'none'}")
            if not isinstance(state, str):
                fields.numbers(f"states[{k}]", len(self._world.get_joint_names(robot.name)), state)
        return state if isinstance(state, str) else tuple(float(x) for x in state)

    def _function(self, fields: Fields) -> dict[str, Any]:
        name = fields.text("function")
        module, colon, attribute = name.partition(":")
        if not colon or not module or not attribute:
            raise fields.refusal("function", name, "module:function")
        if str(self._directory) not in sys.path:
            sys.path.append(str(self._directory))
        found = importlib.util.find_spec(module) if "." not in module else None
        if found is None or not found.origin or not Path(found.origin).is_file():
            raise fields.refusal("function", name, f"in a module that is one file, in {self._directory} or installed")
        source = Path(found.origin).read_bytes()
        try:
            imported = importlib.import_module(module)
        except Exception as error:
            what = " ".join(f"{type(error).__name__}: {error}".split())
            raise fields.refusal("function", name, f"in a module that can be imported ({what})") from error
        if not callable(getattr(imported, attribute, None)):
            raise fields.refusal("function", name, f"a function of {found.origin}")
        self._files[f"functions/{module}.py"] = source
        parameters = fields.mapping("parameters")
        try:
            json.dumps(parameters, allow_nan=False)
        except (TypeError, ValueError) as error:
            allowed = "made of finite numbers, texts, true, false, lists and mappings"
            raise fields.refusal("parameters", parameters, allowed) from error
        return {"function": name, "parameters": plain(parameters)}

    def _variations(self, fields: Fields) -> tuple[dict[str, Any], dict[str, Sampler]]:
        from srmp.datasets.scene_files import read_objects, read_request

        path = fields.file("scene", self._directory)
        base = read_objects(path)
        alone = srmp.PlannerInterface()
        for item in base:  # sizes, poses, names
            try:
                item.add_to(alone)
            except srmp.Error as error:
                raise srmp.InvalidArgument(f"{path}: {error}") from error
        parameters = {
            "base": [item.to_dict() for item in base],
            "poses": {},
            "shift": fields.number("shift", 0.05, 0.0, 10.0),
            "turn": fields.number("turn", 0.1, 0.0, 3.2),
            "moved": list(fields.texts("moved")),
            "object_shift": fields.number("object_shift", 0.03, 0.0, 10.0),
            "object_turn": fields.number("object_turn", 0.3, 0.0, 3.2),
        }
        own = {key: Sampler("configuration") for key in ("start", "goal")}
        if fields.has("request"):
            start, goal = read_request(self._world, self._robots_read[0].name, fields.file("request", self._directory))
            tool = srmp.Pose(p=[0, 0, self._robots_read[0].tool_length])
            parameters["poses"] = {"goal": list(goal @ tool)}
            own = {"start": Sampler("states", states=(start,)), "goal": Sampler("region", ("goal",))}
        return parameters, own


def _list(fields: Fields, value: Any) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise fields.refusal("states", value, "a list of names of states or of configurations")
    return value


def _sampler_of(values: Mapping[str, Any]) -> Sampler:
    states = tuple(state if isinstance(state, str) else tuple(state) for state in values["states"])
    return Sampler(values["source"], tuple(values["regions"]), states, values["pose"])


@contextlib.contextmanager
def _unpacked(files: Mapping[str, bytes]) -> Iterator[Path]:
    """A temporary directory with the files."""
    with tempfile.TemporaryDirectory(prefix="srmp-") as directory:
        unpack(files, Path(directory))
        yield Path(directory)


def unpack(files: Mapping[str, bytes], directory: Path) -> None:
    """Writes the files below a directory."""
    for name, data in files.items():
        path = directory / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
