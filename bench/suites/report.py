"""What the programs of this directory do with results: their own, and those of programs that they run."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import srmp
from srmp._files import write_json


def run_and_report(
    parser: argparse.ArgumentParser, run: Callable[..., dict[str, Any]], table: Callable[[dict[str, Any]], str]
) -> dict[str, Any]:
    """Calls run with the parser's options, writes its result to --out, prints the table of it, and returns it."""
    parser.add_argument("--out", type=Path, help="result file (JSON)")
    options = vars(parser.parse_args())
    out = options.pop("out")
    result = run(**options)
    if out:
        write_json(out, result)
    print(table(result))
    return result


def result_of(what: str, command: Sequence[str], given: str = "") -> Any:
    """What a program with one thread prints last, as JSON; `given` is its standard input."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, env=environment, input=given, capture_output=True, text=True)
    if done.returncode:
        raise srmp.Error(f"{what} failed: {done.stderr.strip().splitlines()[-1]}")
    return json.loads(done.stdout.splitlines()[-1])
