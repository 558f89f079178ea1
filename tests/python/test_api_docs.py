"""The public face: every public name has its contract, in C++ and in Python, and the reference pages are up to date."""

import ast
import importlib.util
import inspect
import re
import sys
from pathlib import Path

import pytest

import srmp
from srmp import _srmp

ROOT = Path(__file__).parents[2]

_spec = importlib.util.spec_from_file_location("make_api_reference", ROOT / "docs" / "make_api_reference.py")
reference = importlib.util.module_from_spec(_spec)
sys.modules[_spec.name] = reference  # dataclasses look their module up
_spec.loader.exec_module(reference)

HEADERS = reference.public_headers()
# Options are defined once, in the registry, which says their meaning: docs/planners.md has the table of it.
OPTIONS = {"srmp/planning/options.hpp"}
PACKAGE = ROOT / "python" / "srmp"

# Methods of PlannerInterface that only one language has, and why.
ONLY_CPP = {
    "scene": "Python has object_names, get_object_pose, get_qpos and the like instead of the object",
    "robot": "Python has get_joint_limits, get_group_states and the like instead of the object",
    "planner_options": "Python gives options as dictionaries: srmp.planner_options",
    "set_collision_backend": "a backend is a C++ class: collisions are checked too often for Python",
}
ONLY_PYTHON = {
    "allowed_collision": "C++: Scene::allowed_collision",
    "get_object_pose": "C++: Scene::object_pose",
    "get_qpos": "C++: Scene::robot(name).q",
    "get_always_colliding": "C++: RobotModel::always_colliding",
    "get_end_effector": "C++: RobotModel::end_effector",
    "get_end_links": "C++: RobotModel::end_links",
    "end_effectors": "C++: RobotModel::end_effectors",
    "get_group_states": "C++: RobotModel::group_states",
    "get_joint_limits": "C++: RobotModel::joints",
    "get_all_joint_limits": "C++: RobotModel::joints and other_joints",
    "print_available_planners": "C++: available_planners, which prints nothing",
    "plot": "figures are in the Python package",
    "show": "the viewer is in the Python package",
    "to_html": "pages are in the Python package",
    "add_robot": "C++ programs add a robot from its files: add_articulation",
    "read_sim": "simulators have Python packages only",
    "simulated_world": "simulators have Python packages only",
}


def is_sentence(text):
    """At least three words that end like a sentence, or begin one that a list or table continues."""
    return len(text.split()) >= 3 and bool(re.search(r"[.?!:)|…]$", text.strip()))


# --- C++


def cpp_declarations():
    def walk(header, declarations):
        for declaration in declarations:
            yield header, declaration
            yield from walk(header, declaration.members)

    for header, declarations in HEADERS.items():
        yield from walk(header, declarations)


def test_headers_are_read():
    """The parser sees what it must: classes, overloads, fields with comments behind them, enumerators."""
    text = """
namespace srmp {
/// A thing.
class Thing {
 public:
  Thing();
  // --- queries
  /// Adds.
  int add(int a,
          int b = 2) const;
  int add(double a) const;
  double x{};  ///< [m] along
               ///< the axis
  void bare();
  bool operator==(const Thing& other) const;

 private:
  int hidden;
};

/// Kinds.
enum class Kind {
  a,  ///< the first
  b,
};
using Things = std::vector<Thing>;
/// Counts.
inline int count(const Things& things) { return static_cast<int>(things.size()); }
}  // namespace srmp
"""
    thing, kind, things, count = reference.parse_header(text)
    assert [(m.kind, m.name, m.doc) for m in thing.members] == [
        ("section", "queries", "queries"),
        ("function", "add", "Adds."),
        ("function", "add", "Adds."),
        ("field", "x", "[m] along the axis"),
        ("function", "bare", ""),
    ]
    assert thing.members[1].text == "int add(int a, int b = 2) const;"
    assert [(m.name, m.doc) for m in kind.members] == [("a", "the first"), ("b", "")]
    assert (things.kind, things.doc) == ("alias", "")
    assert (count.text, count.doc) == ("inline int count(const Things& things);", "Counts.")


@pytest.mark.parametrize("header", HEADERS)
def test_every_public_declaration_has_its_contract(header):
    """Enumerators may go without, where the comment of their enum suffices, and the fields of options."""
    bare = [
        f"{header}:{declaration.line} {declaration.text}"
        for found, declaration in cpp_declarations()
        if found == header and not declaration.doc and declaration.kind != "enumerator"
        if not (header in OPTIONS and declaration.kind == "field")
    ]
    assert not bare, "\n" + "\n".join(bare)


# --- Python


def compiled():
    """(name, object) of all public names of the extension, and of their public members."""
    for name, value in vars(_srmp).items():
        if name.startswith("_") or inspect.ismodule(value):
            continue
        yield name, value
        if inspect.isclass(value):
            for member, item in vars(value).items():
                if not member.startswith("_"):
                    yield f"{name}.{member}", item


def test_every_name_of_the_extension_has_a_docstring():
    wrong = [name for name, value in compiled() if not is_sentence(words_of(value))]
    assert not wrong, wrong


def words_of(value):
    """The docstring without the signature that nanobind puts before it."""
    text = inspect.getdoc(value.fget if isinstance(value, property) else value) or ""
    if isinstance(value, property):
        text = value.__doc__ or text
    lines = [line for line in text.splitlines() if not re.match(r"^\w*\(.*\)( -> .*)?$", line)]
    return "\n".join(lines).strip()


def python_modules():
    return [file for file in PACKAGE.rglob("*.py") if is_public(file)]


def is_public(file):
    return not any(part.startswith("_") for part in file.relative_to(PACKAGE).with_suffix("").parts if part[:2] != "__")


def classes_by_name():
    trees = [ast.parse(file.read_text()) for file in PACKAGE.rglob("*.py")]
    return {node.name: node for tree in trees for node in tree.body if isinstance(node, ast.ClassDef)}


def has_docstring(function, owner, classes):
    """A method that overrides a documented one may go without."""
    if is_sentence(ast.get_docstring(function) or ""):
        return True
    if owner is None or ast.get_docstring(function):
        return False
    if any(ast.unparse(decorator).endswith(".setter") for decorator in function.decorator_list):
        return True
    for base in owner.bases:
        above = classes.get(ast.unparse(base))
        for item in above.body if above else ():
            if isinstance(item, ast.FunctionDef) and item.name == function.name:
                return has_docstring(item, above, classes)
    return False


@pytest.mark.parametrize("file", python_modules(), ids=lambda file: str(file.relative_to(PACKAGE)))
def test_every_public_name_of_a_module_has_a_docstring(file):
    tree, classes = ast.parse(file.read_text()), classes_by_name()
    wrong = [] if ast.get_docstring(tree) or file.name == "__main__.py" else ["the module"]
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            wrong += [] if has_docstring(node, None, classes) else [node.name]
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            wrong += [] if is_sentence(ast.get_docstring(node) or "") else [node.name]
            wrong += [
                f"{node.name}.{item.name}"
                for item in node.body
                if isinstance(item, ast.FunctionDef) and not item.name.startswith("_")
                if not has_docstring(item, node, classes)
            ]
    assert not wrong, wrong


# --- both


def planner_interface():
    """Its functions in C++, by name: the contracts."""
    (found,) = [d for d in HEADERS["srmp/planner_interface.hpp"] if d.name == "PlannerInterface"]
    functions = [member for member in found.members if member.kind == "function"]
    return {member.name: member.doc for member in reversed(functions)}  # of overloads: the first


def test_both_languages_have_the_same_methods():
    cpp = set(planner_interface())
    python = {name for name in vars(srmp.PlannerInterface) if not name.startswith("_")}
    assert cpp - python == set(ONLY_CPP)
    assert python - cpp == set(ONLY_PYTHON)


def first_words(text):
    """What C++ and Python say alike: the beginning, without arguments in brackets and the types of one language."""
    text = re.sub(r"\([^()]*\)|`", "", " ".join(text.split()))
    return re.sub(r"\W+", " ", text).split()[:3]


@pytest.mark.parametrize("name", sorted(set(planner_interface()) - set(ONLY_CPP)))
def test_both_languages_begin_with_the_same_words(name):
    python = words_of(inspect.getattr_static(srmp.PlannerInterface, name))
    assert first_words(python) == first_words(planner_interface()[name])


# --- the reference


def test_the_reference_of_cpp_is_up_to_date():
    text = (ROOT / "docs" / "api-cpp.md").read_text(encoding="utf-8")
    assert text == reference.cpp_page(), "stale: run python docs/make_api_reference.py"


def test_the_reference_of_python_is_up_to_date():
    text = (ROOT / "docs" / "api-python.md").read_text(encoding="utf-8")
    page = reference.python_page(reference.stub_file())
    assert text == page, "stale: run python docs/make_api_reference.py"
