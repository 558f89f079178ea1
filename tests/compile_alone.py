"""Compiles every source of the library by itself, without code: python tests/compile_alone.py BUILD_DIRECTORY [PART...]

With parts of names, only the sources whose path contains one of them (to check one's own change in seconds).
The package is built with the sources of a directory as one (SRMP_UNITY_BUILD), where a source also sees what its
neighbours include. The presets for developers and for sanitizers compile each by itself.
"""

import json
import os
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
HEADER = "src/srmp/CMakeFiles/srmp.dir/cmake_pch.hxx.gch"  # precompiled, of all sources


def commands(build: Path) -> list[tuple[str, list[str]]]:
    """(source, command without output) of each source of the library."""
    found = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = Path(entry["file"])
        if source.suffix != ".cpp" or (PROJECT / "src") not in source.parents:
            continue
        arguments = shlex.split(entry["command"])
        output = arguments.index("-o")
        found.append(
            (str(source.relative_to(PROJECT)), [*arguments[:output], *arguments[output + 2 :], "-fsyntax-only"])
        )
    return found


def main() -> None:
    build = Path(sys.argv[1])
    configure = ["cmake", "-Wno-dev", "-G", "Ninja", "-S", PROJECT, "-B", build, "-DSRMP_UNITY_BUILD=OFF"]
    configure += ["-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DPython_FIND_VIRTUALENV=FIRST"]
    subprocess.run(configure, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", build, HEADER], check=True, stdout=subprocess.DEVNULL)

    def compile_alone(item: tuple[str, list[str]]) -> bool:
        source, command = item
        result = subprocess.run(command, cwd=build, capture_output=True, text=True)
        if result.returncode:
            print(f"{source} does not compile by itself:\n{result.stderr}")
        return result.returncode == 0

    sources = [(s, c) for s, c in commands(build) if any(part in s for part in sys.argv[2:] or [""])]
    workers = int(os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", os.cpu_count() or 1))
    with ThreadPoolExecutor(workers) as pool:
        passed = sum(pool.map(compile_alone, sources))
    print(f"{passed} of {len(sources)} sources compile by themselves")
    if not sources or passed < len(sources):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
