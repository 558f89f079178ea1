"""The benchmarks' runner: workers, the journal of a run that was killed, and Ray."""

import json
import os
import signal
import subprocess
import sys
import time
import types
from dataclasses import dataclass, replace

import numpy as np
import pytest
from click.testing import CliRunner

import srmp
from srmp.bench import mbm
from srmp.bench.runner import Execution, run_rows
from srmp.cli import main

MEASURED = ("_time_s", "memory_bytes")


@dataclass(frozen=True)
class Number:
    value: int

    @property
    def name(self):
        return f"number/{self.value}"


class Squares:
    """Squares numbers, the later ones sooner, and tells which it was asked for."""

    def __init__(self, asked=None):
        self.asked = asked if asked is not None else []

    def run(self, number):
        self.asked.append(number.value)
        time.sleep(0.01 * (number.value % 3 == 0))
        return {"problem": number.name, "square": np.array([number.value**2]), "inf": np.inf, "worker": os.getpid()}


class Dies(Squares):
    def run(self, number):
        os.kill(os.getpid(), signal.SIGKILL)


NUMBERS = [Number(k) for k in range(12)]
REQUEST = {"benchmark": "squares", "up_to": 12}


def run(**settings):
    return run_rows(NUMBERS, Squares, **{"request": REQUEST, **settings})


def without_workers(rows):
    return [{key: value for key, value in row.items() if key != "worker"} for row in rows]


def test_rows_are_in_order_for_any_number_of_workers():
    alone, complete = run()
    assert complete
    assert [row["square"] for row in alone] == [[k**2] for k in range(12)]
    assert {row["worker"] for row in alone} == {os.getpid()}
    for workers in (2, 3):
        rows, complete = run(execution=Execution(workers))
        assert complete
        assert without_workers(rows) == without_workers(alone)
        assert os.getpid() not in {row["worker"] for row in rows}


def test_a_worker_that_dies_is_reported(tmp_path):
    execution = Execution(2, journal=tmp_path / "out.json.part")
    with pytest.raises(srmp.Error, match=r"was killed .* keeps the rows so far"):
        run_rows(NUMBERS, Dies, request=REQUEST, execution=execution)


# --- journal ----------------------------------------------------------------------------------------------------------


class Stop(Exception):
    pass


class StopsAt(Squares):
    def run(self, number):
        if number.value == 5:
            raise Stop
        return super().run(number)


@pytest.fixture
def journal(tmp_path):
    """Of a run that ended before number 5."""
    path = tmp_path / "out.json.part"
    with pytest.raises(Stop):
        run(solver=StopsAt(), execution=Execution(journal=path))
    assert len(path.read_text().splitlines()) == 1 + 5
    return path


def resume(journal, **settings):
    asked = []
    execution = Execution.beside(str(journal).removesuffix(".part"))
    assert execution.journal == journal
    rows, complete = run(solver=Squares(asked), execution=execution, **settings)
    assert complete
    assert without_workers(rows) == without_workers(run()[0])
    execution.finish()
    assert not journal.exists()
    return asked


def test_a_run_goes_on_where_it_ended(journal):
    assert resume(journal) == list(range(5, 12))


def test_a_complete_journal_needs_no_solver(journal):
    run(execution=Execution(journal=journal))
    assert resume(journal) == []


@pytest.mark.parametrize("lost", [1, 20])
def test_a_torn_last_line_is_run_again(journal, lost):
    journal.write_bytes(journal.read_bytes()[:-lost])
    assert resume(journal) == list(range(4, 12))


def test_a_torn_header_begins_anew(journal):
    journal.write_bytes(journal.read_bytes()[:10])
    assert resume(journal) == list(range(12))


def test_the_journal_of_another_run_is_refused(journal):
    before = journal.read_bytes()
    with pytest.raises(srmp.FileError, match=r"of another run .up_to: 12 there, 13 here"):
        run(request={**REQUEST, "up_to": 13}, execution=Execution(journal=journal))
    assert journal.read_bytes() == before


@pytest.mark.parametrize("text", ["[1, 2]\n", "hello\n", "hello", '{"format": "something else"}\n', "a\nb"])
def test_what_is_no_journal_is_refused_and_kept(tmp_path, text):
    path = tmp_path / "notes.part"
    path.write_text(text)
    with pytest.raises(srmp.FileError, match="is not the journal of a benchmark"):
        run(execution=Execution(journal=path))
    assert path.read_text() == text


def test_two_runs_do_not_share_a_journal(journal):
    class Second(Squares):
        def run(self, number):
            with pytest.raises(srmp.FileError, match="in use by another run"):
                run(execution=Execution(journal=journal))
            return super().run(number)

    run(solver=Second(), execution=Execution(journal=journal))


def test_ctrl_c_keeps_the_rows(journal):
    class Interrupted(Squares):
        def run(self, number):
            if number.value == 7:
                raise KeyboardInterrupt
            return super().run(number)

    rows, complete = run(solver=Interrupted(), execution=Execution(journal=journal))
    assert not complete
    assert len(rows) == 7
    assert resume(journal) == list(range(7, 12))


# --- Ray --------------------------------------------------------------------------------------------------------------


def test_without_ray_one_sentence_helps(monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(srmp.Error, match=r"Ray is not installed: pip install .* or use --workers alone"):
        run(execution=Execution(ray="auto"))


@pytest.fixture
def stand_in_for_ray(monkeypatch):
    """What of Ray is used, in one process; `actors` holds those that were made."""
    actors = []

    def remote(**_):
        def decorate(cls):
            def make():
                actors.append(cls())
                solve = actors[-1].solve
                return types.SimpleNamespace(solve=types.SimpleNamespace(remote=solve))

            return types.SimpleNamespace(remote=make)

        return decorate

    class ActorPool:
        def __init__(self, workers):
            self.workers = workers

        def map(self, call, values):
            return (call(self.workers[k % len(self.workers)], value) for k, value in enumerate(values))

    ray = types.ModuleType("ray")
    ray.init = lambda address, **_: None
    ray.shutdown = lambda: None
    ray.cluster_resources = lambda: {"CPU": 3.0}
    ray.remote = remote
    ray.util = types.ModuleType("ray.util")
    ray.util.ActorPool = ActorPool
    monkeypatch.setitem(sys.modules, "ray", ray)
    monkeypatch.setitem(sys.modules, "ray.util", ray.util)
    return actors


@pytest.mark.parametrize(("workers", "actors"), [(None, 3), (2, 2), (50, len(NUMBERS))])
def test_ray_gives_the_same_rows(stand_in_for_ray, workers, actors):
    rows, complete = run(execution=Execution(workers, ray="auto"))
    assert complete
    assert without_workers(rows) == without_workers(run()[0])
    assert len(stand_in_for_ray) == actors


def test_rays_own_cluster_gives_the_same_rows():
    pytest.importorskip("ray", reason="pip install '.[ray]' to run this test")
    rows, complete = run(execution=Execution(2, ray="local"))
    assert complete
    assert without_workers(rows) == without_workers(run()[0])


# --- the commands -----------------------------------------------------------------------------------------------------


def repeatable(value):
    """Without what is measured."""
    if isinstance(value, dict):
        return {key: repeatable(item) for key, item in value.items() if not key.endswith(MEASURED)}
    return [repeatable(item) for item in value] if isinstance(value, list) else value


def bench(*arguments):
    outcome = CliRunner().invoke(main, ["bench", *map(str, arguments)])
    assert outcome.exit_code == 0, outcome.output
    return outcome


@pytest.mark.parametrize("command", ["mbm", "multi"])
def test_two_workers_write_the_same_rows(command, stand_in_dir, tmp_path):
    arguments = {
        "mbm": ["mbm", "--robot", "panda", "--scenario", "box", "--problems", "1-3"],
        "multi": ["multi", "--scenario", "grid", "--robots", "2", "--problems", "1-3", "--planner", "prioritised"],
    }[command]
    results = []
    for workers in (1, 2):
        out = tmp_path / f"{workers}.json"
        bench(*arguments, "--data", stand_in_dir, "--workers", workers, "--out", out)
        results.append(json.loads(out.read_text()))
        assert not out.with_suffix(".json.part").exists()
    assert results[1]["header"]["workers"] == 2
    assert [row["status"] for row in results[0]["rows"]] == ["solved"] * 3
    assert all(row["found_by"] for row in results[0]["rows"])
    assert repeatable(results[0]["rows"]) == repeatable(results[1]["rows"])


def test_a_worker_without_the_files_of_a_problem_unpacks_them(stand_in_dir, tmp_path):
    """One on another machine, where the temporary directory of the first does not exist."""
    files = mbm.robot_files(stand_in_dir, "panda", "urdf")
    with mbm.open_problems(files.directory, "panda", ["box"], {2}) as (problem,):
        elsewhere = replace(problem, scene=tmp_path / "none", request=tmp_path / "none")
        rows = [mbm.Runner(files, "wAstar", {}, 5.0).run(p) for p in (problem, elsewhere)]
    assert rows[0]["status"] == "solved"
    assert np.array_equal(rows[0]["path"], rows[1]["path"])


def begin(journal, *arguments):
    """Starts a command, in a process group of its own, and waits until its first row is in the journal."""
    command = subprocess.Popen(
        [sys.executable, "-m", "srmp.cli", "bench", *map(str, arguments)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    deadline = time.monotonic() + 60
    while not (journal.exists() and len(journal.read_text().splitlines()) >= 2):
        assert time.monotonic() < deadline, "no row was written"
        assert command.poll() is None
        time.sleep(0.02)
    return command


@pytest.fixture
def slow(stand_in_dir, tmp_path):
    """A command that takes a second for each of four problems: in none of them is the straight line free, after which
    ARAstar would end."""
    problems = ["--scenario", "box", "--scenario", "bookshelf_tall", "--problems", "1,4"]
    arguments = ["mbm", "--data", stand_in_dir, "--robot", "panda", *problems, "--time-limit", "1"]
    return [*arguments, "--planner", "ARAstar", "--out", tmp_path / "results.json"]


def test_a_killed_command_goes_on(slow, tmp_path):
    out, journal = tmp_path / "results.json", tmp_path / "results.json.part"
    command = begin(journal, *slow)
    command.kill()
    command.wait()
    kept = [json.loads(line) for line in journal.read_text().splitlines()[1:] if line.endswith("}")]
    assert not out.exists()
    refused = CliRunner().invoke(main, ["bench", *map(str, slow), "--planner", "wAstar"])
    assert refused.exit_code == 2
    assert 'planner: "ARAstar" there, "wAstar" here' in refused.output
    assert "going on where that run ended" in bench(*slow).output
    assert not journal.exists()
    rows = json.loads(out.read_text())["rows"]
    assert len(rows) == 4
    assert rows[0]["total_time_s"] == kept[0]["total_time_s"]  # not solved again


def test_ctrl_c_ends_the_workers_too(slow, tmp_path):
    out, journal = tmp_path / "results.json", tmp_path / "results.json.part"
    command = begin(journal, *slow, "--workers", 2)
    os.killpg(command.pid, signal.SIGINT)
    _, said = command.communicate(timeout=30)
    assert command.returncode == 1
    assert said.splitlines()[-1] == "Aborted!"
    assert "Traceback" not in said
    written = json.loads(out.read_text())
    assert not written["header"]["complete"]
    assert 1 <= len(written["rows"]) < 4
    kept = len(journal.read_text().splitlines()) - 1
    assert kept - len(written["rows"]) in (0, 1)  # the signal may come between the two
