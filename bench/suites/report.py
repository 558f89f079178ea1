"""What the programs of this directory do with their results."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

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
