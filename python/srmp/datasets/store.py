"""A data set's directory: shards named by their content, an index, the robots' files; every file whole or not there."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import srmp
from srmp._files import plain, write_bytes, write_json
from srmp.datasets.fields import Fields
from srmp.datasets.recorder import MadeShard
from srmp.datasets.schema import need_pyarrow, versions
from srmp.datasets.spec import FORMAT, FORMAT_VERSION, Spec

INDEX = "index.json"
RUNS = "runs.jsonl"
_SHARD = re.compile(r"shard-(\d{6,})-([0-9a-f]{32})\.parquet")
_GO_ON = "the shards that are there are complete; the same command goes on from them"


@dataclass(frozen=True)
class Shard:
    """A shard of the index."""

    number: int
    name: str
    sha256: str
    records: int


def shard_name(number: int, sha256: str) -> str:
    """The file name of a shard."""
    return f"shard-{number:06d}-{sha256[:32]}.parquet"


def parse_shard_name(name: str) -> tuple[int, str] | None:
    """Its number and the first half of its hash; None for other files."""
    match = _SHARD.fullmatch(name)
    return (int(match[1]), match[2]) if match else None


def hash_of(shards: list[Shard]) -> str:
    """The SHA-256 of a whole data set: that of its shards' hashes, one after the other."""
    return hashlib.sha256("".join(shard.sha256 for shard in shards).encode()).hexdigest()


class Store:
    """The directory while a data set is made. A context manager; one process at a time has it."""

    def __init__(self, directory: Path, spec: Spec) -> None:
        self.directory, self._spec = directory, spec
        self.shards: dict[int, Shard] = {}
        """Those that are there, by number."""

    def __enter__(self) -> Store:
        """Raises FileError where the directory cannot be written, is in use, or holds another data set."""
        with self._explained():
            self.directory.mkdir(parents=True, exist_ok=True)
            self._lock = (self.directory / ".lock").open("w")
        try:
            self._take()
            outdated = self._require_same()
            self.write_files()
            for torn in self.directory.glob("*.part"):
                torn.unlink()
            self.shards = dict(self._found(outdated))
            self.write_index()
        except BaseException:
            self._lock.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def _take(self) -> None:
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise srmp.FileError(f"{self.directory} is in use by another run.") from error

    def _require_same(self) -> set[int]:
        """Refuses a directory whose index is of other records, or that holds files but no index.

        Returns the shards with records that the spec skips now and did not before, or the other way round.
        """
        path = self.directory / INDEX
        if not path.exists():
            if any(parse_shard_name(item.name) for item in self.directory.iterdir()):
                raise srmp.FileError(f"{self.directory} holds shards but no {INDEX}: choose another directory.")
            return set()
        index = read_index(self.directory)
        spec = index["spec"]
        mine = self._spec.content()
        different = [key for key in mine if plain(spec.get(key)) != plain(mine[key])]
        if different or spec.get("records_per_shard") != self._spec.records_per_shard:
            names = ", ".join(different or ["records_per_shard"])
            raise srmp.FileError(
                f"{self.directory} holds a data set of another spec (different: {names}): choose another directory."
            )
        if index["versions"] != versions():
            raise srmp.FileError(
                f"{self.directory} was made by other versions ({json.dumps(index['versions'])}): finish it with those, "
                "or choose another directory."
            )

        return {record // self._spec.records_per_shard for record in {*spec["skip"]} ^ {*self._spec.skip}}

    def _found(self, outdated: set[int]) -> Iterator[tuple[int, Shard]]:
        """Shards with the content that their name says; damaged and outdated ones and those that were not full go."""
        for path in sorted(self.directory.iterdir()):
            if not (named := parse_shard_name(path.name)):
                continue
            number, prefix = named
            sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
            if number < self._spec.shards and sha256.startswith(prefix) and number not in outdated:
                records = need_pyarrow().parquet.read_metadata(path).num_rows
                if records == len(self._spec.numbers(number)):
                    yield number, Shard(number, path.name, sha256, records)
                    continue
            if number >= self._spec.shards:
                raise srmp.FileError(
                    f"{self.directory} holds {path.name}, more than the {self._spec.shards} shards of the spec: raise "
                    "its count, or choose another directory."
                )
            path.unlink()

    def write_files(self) -> None:
        """Writes the files that the data set carries."""
        with self._explained():
            for name, data in self._spec.files.items():
                path = self.directory / name
                path.parent.mkdir(parents=True, exist_ok=True)
                write_bytes(path, data)

    def write_shard(self, made: MadeShard) -> None:
        """Writes a shard: under another name first, so that a file with a shard's name is always whole.

        It is listed before it is written: Ctrl-C may come at any instant, also right after the file gets its name.
        """
        sha256 = hashlib.sha256(made.data).hexdigest()
        shard = Shard(made.number, shard_name(made.number, sha256), sha256, made.count)
        self.shards[made.number] = shard
        with self._explained():
            write_bytes(self.directory / shard.name, made.data)

    def write_index(self) -> None:
        """Writes index.json: the same for the same shards."""
        self._forget_unwritten()
        shards = [self.shards[number] for number in sorted(self.shards)]
        content = {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "complete": len(shards) == self._spec.shards,
            "records": sum(shard.records for shard in shards),
            "sha256": hash_of(shards),
            "identity": self._spec.identity,
            "versions": versions(),
            "spec": self._spec.to_dict(),
            "shards": [vars(shard) for shard in shards],
        }
        with self._explained():
            write_json(self.directory / INDEX, content)

    def add_run(self, about: Mapping[str, Any]) -> None:
        """Appends a line to runs.jsonl: what is different in every run, such as times, is there and nowhere else."""
        path = self.directory / RUNS
        with self._explained():
            before = path.read_bytes() if path.exists() else b""
            write_bytes(path, before + json.dumps(plain(about)).encode() + b"\n")

    def _forget_unwritten(self) -> None:
        """Drops the shard whose writing failed or was interrupted."""
        self.shards = {n: shard for n, shard in self.shards.items() if (self.directory / shard.name).exists()}

    @contextlib.contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._forget_unwritten()
            reason = error.strerror or str(error)
            count = f" after {len(self.shards)} of {self._spec.shards} shards" if self.shards else ""
            rest = f"; {_GO_ON}" if self.shards else ""
            raise srmp.FileError(f"{self.directory} cannot be written{count}: {reason}{rest}.") from error


def read_index(directory: Path) -> dict[str, Any]:
    """The content of index.json. Raises FileError."""
    path = directory / INDEX
    try:
        index = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise srmp.FileError(f"{directory} is not a data set: it has no {INDEX}.") from error
    except (OSError, ValueError) as error:
        raise srmp.FileError(f"{path} cannot be read: {error}.") from error
    if not isinstance(index, dict) or index.get("format") != FORMAT:
        raise srmp.FileError(f"{path} is not the index of a data set.")
    if index.get("format_version") != FORMAT_VERSION:
        version = index.get("format_version")
        raise srmp.FileError(f"{path} has format version {version}; this program reads {FORMAT_VERSION}.")
    missing = [key for key in ("records", "sha256", "identity", "versions", "spec", "shards") if key not in index]
    if missing:
        raise srmp.FileError(f"{path} has no '{missing[0]}'.")
    try:
        _require_types(Fields(index))
        Spec.from_dict(index["spec"], {})
        read_shards(index)
    except (srmp.Error, KeyError, TypeError, ValueError) as error:
        raise srmp.FileError(f"{path} is not as it is written: {error}") from error
    return index


def _require_types(index: Fields) -> None:
    """What all that read an index rely on. Raises InvalidArgument."""
    index.text("sha256"), index.text("identity"), index.whole("records"), index.mapping("versions")
    spec = Fields(index.any("spec"), "spec")
    spec.whole("count", least=1), spec.whole("records_per_shard", least=1), spec.wholes("skip"), spec.mapping("planner")
    for name in spec.mapping("files"):
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise spec.refusal("files", name, "inside the data set")
    for robot in spec.items("robots"):
        robot.text("name"), robot.text("end_effector"), robot.text("group", ""), robot.mapping("fixed_joints")
        robot.numbers("base", 7), robot.number("tool_length")
    for scene in spec.items("scenes"):
        scene.text("name"), scene.text("kind"), scene.mapping("parameters")
        for end in (Fields(scene.any(key), f"spec.scenes.{key}") for key in ("start", "goal")):
            end.text("source"), end.texts("regions")
            if not isinstance(states := end.any("states", required=True), list):
                raise end.refusal("states", states, "a list")


def read_shards(index: Mapping[str, Any]) -> list[Shard]:
    """The shards that the index lists. Raises FileError."""
    for shard in Fields(index).items("shards") if index["shards"] else ():
        shard.whole("number"), shard.text("name"), shard.text("sha256"), shard.whole("records")
    try:
        return [Shard(**item) for item in index["shards"]]
    except TypeError as error:
        raise srmp.FileError(f"the shards of {INDEX} are not as they are written: {error}.") from error
