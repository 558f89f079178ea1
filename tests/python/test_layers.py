"""Include directions, circles of includes, who reads the clock, and how long files and functions are."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = (ROOT / "include" / "srmp", ROOT / "src" / "srmp")

# docs/architecture.md has the same list.
MAY_INCLUDE = {
    "core": set(),
    "geometry": {"core"},
    "cover": {"core", "geometry"},
    "robot": {"core", "geometry", "cover"},
    "scene": {"core", "geometry", "robot"},
    "collision": {"core", "geometry", "cover", "robot", "scene"},
    "search": {"core"},
    "multi": {"core", "search"},
    "lattice": {"core", "robot", "search"},
    "heuristic": {"core", "geometry", "robot", "scene"},
    "trajectory": {"core", "robot", "collision"},
    "io": {"core", "robot", "scene", "lattice", "trajectory"},
}
MAY_INCLUDE["planning"] = set(MAY_INCLUDE)
MAY_INCLUDE["facade"] = set(MAY_INCLUDE) | {"planning"}


def source_files():
    return [file for source in SOURCES for file in source.rglob("*.[hc]pp")] + [
        file for source in SOURCES for file in source.rglob("*.h")
    ]


def name_of(file):
    """As an #include has it: "srmp/core/pose.hpp"."""
    return next(str(file.relative_to(source.parent)) for source in SOURCES if file.is_relative_to(source))


def module_of(name):
    """Headers straight in include/srmp are the facade's."""
    parts = name.split("/")
    return parts[1] if len(parts) > 2 else "facade"


def included_by(file):
    return re.findall(r'#include "(srmp/[^"]+)"', file.read_text())


@pytest.mark.parametrize("module", sorted(MAY_INCLUDE))
def test_module_includes_only_what_lies_below_it(module):
    files = [file for file in source_files() if module_of(name_of(file)) == module]
    assert files
    for file in files:
        included = {module_of(name) for name in included_by(file)}
        assert included <= MAY_INCLUDE[module] | {module}, f"{name_of(file)} includes {sorted(included)}"


def test_every_module_has_its_place():
    assert {module_of(name_of(file)) for file in source_files()} == set(MAY_INCLUDE)


def circle(graph):
    """Names along a circle of the graph {name: names it needs}, or [] when there is none."""
    done = set()

    def walk(name, path):
        if name in path:
            return [*path[path.index(name) :], name]
        if name in done:
            return []
        for needed in graph.get(name, ()):
            if found := walk(needed, [*path, name]):
                return found
        done.add(name)
        return []

    return next((found for name in graph if (found := walk(name, []))), [])


def test_a_circle_is_found():
    assert circle({"a": ["b"], "b": ["c"], "c": ["b"]}) == ["b", "c", "b"]
    assert circle({"a": ["b", "c"], "b": ["c"], "c": []}) == []


def test_no_files_include_in_a_circle():
    """A source belongs to its header: what the one includes, the other does too."""
    graph = {}
    for file in source_files():
        unit = re.sub(r"\.(cpp|hpp|h)$", "", name_of(file))
        needed = {re.sub(r"\.(hpp|h)$", "", name) for name in included_by(file)} - {unit}
        graph.setdefault(unit, set()).update(needed)
    assert circle({unit: sorted(needed) for unit, needed in graph.items()}) == []


def python_imports(file, package):
    """Modules of the package that a module imports when it is imported itself, or in any of its functions."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = file.parent
            for _ in range(node.level - 1):
                base = base.parent
            target = base / Path(*(node.module.split(".") if node.module else []))
            for alias in node.names:
                inner = target / alias.name
                yield inner if inner.with_suffix(".py").exists() or inner.is_dir() else target
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == package.name:
            yield package.parent / Path(*node.module.split("."))


def test_no_python_modules_import_in_a_circle():
    package = ROOT / "python" / "srmp"
    graph = {}
    for file in package.rglob("*.py"):
        unit = file.parent if file.name == "__init__.py" else file.with_suffix("")
        needed = {target for target in python_imports(file, package) if target != package} - {unit}
        graph[str(unit.relative_to(package.parent))] = sorted(str(n.relative_to(package.parent)) for n in needed)
    assert circle(graph) == []


PLANNING_MODULES = {"planning", "search", "multi", "lattice", "heuristic", "collision", "trajectory"}
# These write times into statistics and certificates, for users.
CLOCK_READERS = {
    "srmp/core/deadline.hpp",
    "srmp/planning/cartesian/follow_poses.cpp",
    "srmp/planning/obstacles/moving_obstacles.cpp",
    "srmp/planning/parallel_work.cpp",
    "srmp/planning/phase_timer.hpp",
    "srmp/planning/pipeline.cpp",
    "srmp/planning/solution_record.cpp",
    "srmp/planning/statistics_fields.hpp",
    "srmp/planning/strategies/lattice_search.cpp",
    "srmp/trajectory/certify.cpp",
}


def uses_of_time(text):
    """Where a source reads a clock, or a time that was measured; timers and assignments to statistics do not count."""
    read = re.findall(r"chrono::|elapsed\(\)|remaining\(\)", text)
    for line in text.splitlines():
        if not re.search(r"PhaseTimer|//", line):
            read += re.findall(r"\w+_time_s_?\b(?!\{|\s*[-+]?=[^=])", line)
    return read


def test_uses_of_time_are_found():
    assert uses_of_time("to_prove = std::max(statistics_.verification_time_s, share * deadline_.remaining());")
    assert uses_of_time("if (statistics.search_time_s == 0.0)")
    assert uses_of_time("std::chrono::steady_clock::now()")
    assert not uses_of_time("const PhaseTimer timer(until, statistics.timing_time_s); statistics.ik_time_s = 0.0;")


def test_the_clock_stops_work_and_never_steers_it():
    """Nothing is given a share of the time that is left: a request has one answer for all limits it does not reach."""
    for file in source_files():
        name = name_of(file)
        if module_of(name) not in PLANNING_MODULES or not file.is_relative_to(SOURCES[1]):
            continue
        text = file.read_text()
        assert name in CLOCK_READERS or not uses_of_time(text), f"{name} reads the clock"
        for seconds in re.findall(r"deadline\w*(?:\.|->)within\((.*)\)", text):
            assert ".max_time()" in seconds, f"{name}: within({seconds}) is not a time that the user asked for"


def test_headers_keep_pinocchio_and_coal_out():
    for file in (SOURCES[0]).rglob("*.hpp"):
        public = "#include <pinocchio" not in file.read_text() and "#include <coal" not in file.read_text()
        assert public, f"{name_of(file)} would force its users to have Pinocchio or Coal"


def test_public_headers_include_public_headers_only():
    public = {name_of(file) for file in SOURCES[0].rglob("*.hpp")}
    for file in SOURCES[0].rglob("*.hpp"):
        assert set(included_by(file)) <= public, name_of(file)


MAX_LINES_OF_FILE, MAX_LINES_OF_FUNCTION = 600, 60
PROGRAM = ("include", "src", "python", "bench", "docs", "examples", "moveit")


def program_files(*suffixes, directories=PROGRAM):
    return [f for name in directories for f in sorted((ROOT / name).rglob("*")) if f.suffix in suffixes]


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def cpp_functions(text):
    """(head, lines) of each function defined in a C++ source, without those inside functions.

    A function is an outermost block whose head ends as a parameter list or a list of initialisers does.
    """
    text = re.sub(
        r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', blank, text, flags=re.S
    )
    text = re.sub(r"(?m)^[ \t]*#(?:.*\\\n)*.*", blank, text)
    found, open_blocks, last = [], [], 0
    for match in re.finditer(r"[{};]", text):
        begin = last + len(text[last : match.start()]) - len(text[last : match.start()].lstrip())
        head, last = " ".join(text[begin : match.start()].split()), match.end()
        if match[0] == "{":
            outermost = not any(is_function for _, is_function, _ in open_blocks)
            ends = re.search(r"\)(\s|const|noexcept|override|final|&|->[\w:<>,\s*&]+)*$|\) : \w", head)
            type_or_namespace = re.match(r"(template <.*> )?(namespace|class|struct|enum|union)\b", head)
            open_blocks.append((begin, bool(outermost and ends and not type_or_namespace), head))
        elif match[0] == "}":
            begin, is_function, head = open_blocks.pop()
            if is_function:
                found.append((head, text.count("\n", begin, match.end()) + 1))
    assert not open_blocks
    return found


def python_functions(text):
    functions = [n for n in ast.walk(ast.parse(text)) if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef))]
    return [(node.name, node.end_lineno - node.lineno + 1) for node in functions]


def test_functions_are_found():
    text = """
struct Point { double x{}; Point(double x) : x(x) {} };
// void not_this() {
int f(int a,
      int b) {
  const auto g = [&](int c) { return "}" + c; };
  for (;;) {
  }
}
"""
    assert [lines for _, lines in cpp_functions(text)] == [1, 6]
    assert cpp_functions(text)[1][0] == "int f(int a, int b)"
    assert python_functions("def f():\n    x = 1\n    return x\n") == [("f", 3)]


def test_files_are_short():
    files = program_files(".hpp", ".cpp", ".h", ".py", directories=(*PROGRAM, "packaging", "tests"))
    assert len(files) > 800
    lengths = {str(file.relative_to(ROOT)): len(file.read_text().splitlines()) for file in files}
    assert not {name: lines for name, lines in lengths.items() if lines > MAX_LINES_OF_FILE}


def test_functions_fit_a_screen():
    """But for the tables of bindings, whose functions are named bind_…."""
    long, found = [], 0
    cpp = program_files(".hpp", ".cpp", directories=("include", "src", "python", "bench", "examples"))
    for file in [*cpp, *program_files(".py")]:
        functions = (python_functions if file.suffix == ".py" else cpp_functions)(file.read_text())
        found += len(functions)
        long += [
            f"{file.relative_to(ROOT)}: {head} has {lines} lines"
            for head, lines in functions
            if lines > MAX_LINES_OF_FUNCTION and not re.search(r"\bvoid bind_\w+\(", head)
        ]
    assert found > 3000
    assert long == []


def test_few_headers_are_installed():
    installed = {file for file in SOURCES[0].rglob("*") if file.is_file()}
    assert len(installed) <= 40, "the public face grows: is all of this for users?"


def test_what_the_moveit_plugin_includes_is_compiled_as_cpp17():
    def included(*files):
        return {name for file in files for name in re.findall(r"#include [<\"](srmp/[^>\"]+)", file.read_text())}

    plugin = (ROOT / "moveit").rglob("*.[hc]pp")
    assert included(*plugin) == included(ROOT / "tests" / "support" / "cxx17.cpp") != set()
