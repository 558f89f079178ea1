"""Writes docs/api-cpp.md from the headers in include/srmp, and docs/api-python.md from the stubs of the built package.

    python docs/make_api_reference.py           writes both pages; the package srmp must be importable
    python docs/make_api_reference.py --check   names the stale pages and exits with 1

The headers are read line by line, which suffices for the way they are written: a contract is a `///` comment above its
declaration or a `///<` comment behind it, and clang-format has put every declaration on lines of its own.
"""

from __future__ import annotations

import argparse
import ast
import itertools
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HEADERS = ROOT / "include" / "srmp"
PACKAGE = ROOT / "python" / "srmp"
CPP_PAGE = ROOT / "docs" / "api-cpp.md"
PYTHON_PAGE = ROOT / "docs" / "api-python.md"

# --- C++


@dataclass
class Declaration:
    """One public declaration of a header."""

    kind: str  # "class", "struct", "enum", "function", "field", "enumerator", "alias" or "section" (a comment // --- …)
    name: str
    text: str  # the declaration on one line, without a body
    doc: str  # its comment; "" if there is none
    line: int
    scope: str = ""  # the class it is in, "" for the namespace
    members: list[Declaration] = field(default_factory=list)


_SCOPE = re.compile(r"^(?:template <[^{;]*> )?(namespace|class|struct|enum class|enum)\b\s*(?:([\w:]+)\s*)?[^;()]*$")
_ACCESS = re.compile(r"^(public|private|protected):")


def parse_header(text: str) -> list[Declaration]:
    """The declarations at namespace level, those of a class as its members; private ones are left out."""
    return _Parser(text).run()


class _Parser:
    def __init__(self, text: str) -> None:
        self._lines = text.splitlines()
        self._at = 0
        self._found: list[Declaration] = []

    def run(self) -> list[Declaration]:
        self._read_scope(self._found, "", "namespace", True)
        _share_docs_of_overloads(self._found)
        return self._found

    def _read_scope(self, into: list[Declaration], scope: str, kind: str, public: bool) -> None:
        """Reads up to the scope's closing brace."""
        doc: list[str] = []
        while self._at < len(self._lines):
            line = self._lines[self._at].strip()
            if line.startswith("}"):
                self._at += 1
                return
            if match := _ACCESS.match(line):
                public = match[1] == "public"
            if line.startswith("///") and not line.startswith("///<"):
                doc.append(line[3:].removeprefix(" "))
            if line.startswith("// --- ") and public:
                into.append(Declaration("section", line[7:], line, line[7:], self._at + 1, scope))
            if not line or line.startswith(("#", "//")) or _ACCESS.match(line):
                doc = doc if line.startswith("///") else []
                self._at += 1
                continue
            if kind.startswith("enum"):
                self._read_enumerators(into, scope, doc)
            else:
                self._read_declaration(into if public else [], scope, doc)
            doc = []

    def _read_declaration(self, into: list[Declaration], scope: str, doc: list[str]) -> None:
        first = self._at
        text, trailing = "", []
        while self._at < len(self._lines):
            code, _, comment = self._lines[self._at].partition("//")
            self._at += 1
            if comment.startswith("/<"):
                trailing.append(comment[2:].strip())
            text = f"{text} {code.strip()}".strip()
            if opened := _SCOPE.match(text.removesuffix("{").strip()) if text.endswith("{") else None:
                self._open(into, scope, opened, text, doc, first)
                return
            if text.count("{") == text.count("}") and text.endswith((";", "}")):
                break
        while self._at < len(self._lines) and self._lines[self._at].strip().startswith("///<"):
            trailing.append(self._lines[self._at].strip()[4:].strip())
            self._at += 1
        into.extend(_declarations(text, _joined(doc, trailing), first + 1, scope))

    def _open(
        self, into: list[Declaration], scope: str, opened: re.Match[str], text: str, doc: list[str], first: int
    ) -> None:
        kind, name = opened[1], opened[2] or ""
        if kind == "namespace":
            self._read_scope(into, scope, "namespace", True)
            return
        head = re.sub(r"\s+", " ", text.removesuffix("{")).strip()
        declaration = Declaration(kind.split()[0], name, head, _joined(doc, []), first + 1, scope)
        if name:
            into.append(declaration)
        self._read_scope(declaration.members, name, kind, kind != "class")
        _share_docs_of_overloads(declaration.members)

    def _read_enumerators(self, into: list[Declaration], scope: str, doc: list[str]) -> None:
        code, _, comment = self._lines[self._at].partition("//")
        line = self._at + 1
        self._at += 1
        trailing = [comment[2:].strip()] if comment.startswith("/<") else []
        while self._at < len(self._lines) and self._lines[self._at].strip().startswith("///<"):
            trailing.append(self._lines[self._at].strip()[4:].strip())
            self._at += 1
        for name in filter(None, (part.strip() for part in code.split(","))):
            into.append(Declaration("enumerator", name, name, _joined(doc, trailing), line, scope))


def _joined(above: list[str], behind: list[str]) -> str:
    return "\n".join([*above, " ".join(behind)]).strip()


def _declarations(text: str, doc: str, line: int, scope: str) -> list[Declaration]:
    """The declaration of this text; none for what needs no comment."""
    text = re.sub(r"\s+", " ", text)
    if _needs_no_comment(text, scope):
        return []
    if text.startswith("using "):
        name = text.split()[1]
        return [Declaration("alias", name, text, doc, line, scope)]
    head = re.sub(r"<[^()]*>", "", text)
    is_function = "(" in head.split("{")[0].split("=")[0] or "operator" in text
    if is_function:
        match = re.search(r"(operator\s*\S+?|~?\w+)\s*\(", head)
        signature = re.sub(r"\s*\{.*\}$", ";", text)  # without its body
        return [Declaration("function", match[1] if match else text, signature, doc, line, scope)]
    names = re.findall(r"(\w+)\s*(?:\{[^{}]*(?:\{[^{}]*\}[^{}]*)*\}|=[^,;]*)?\s*[,;]", head)
    return [Declaration("field", names[0] if names else text, text, doc, line, scope)]


def _needs_no_comment(text: str, scope: str) -> bool:
    """Whether it is a forward declaration, a friend, a constructor, a destructor, an assignment or a comparison."""
    if re.match(r"^(template <.*> )?(class|struct|enum class|union) [\w:]+;$", text) or text.startswith(
        ("friend ", "extern template")
    ):
        return True
    if re.match(r"^using [\w:]+;$", text) or text in (";", "};"):
        return True
    name = scope.split("::")[-1]
    own = rf"^(explicit |constexpr |inline |virtual )*~?{re.escape(name)}\(" if name else r"^$"
    return bool(re.match(own, text)) or "operator=(" in text.replace(" ", "") or "operator==" in text


def _share_docs_of_overloads(declarations: list[Declaration]) -> None:
    """An overload without a comment of its own has that of the one just before it."""
    for before, after in itertools.pairwise(declarations):
        if not after.doc and after.kind == before.kind == "function" and after.name == before.name:
            after.doc = before.doc


def public_headers() -> dict[str, list[Declaration]]:
    """The declarations of every header, by its name as an #include has it."""
    files = sorted(HEADERS.rglob("*.hpp"), key=lambda file: (file.parent != HEADERS, str(file)))
    return {str(file.relative_to(HEADERS.parent)): parse_header(file.read_text(encoding="utf-8")) for file in files}


_NOTE = "<!-- Written by docs/make_api_reference.py; do not edit. -->"


def cpp_page() -> str:
    """docs/api-cpp.md."""
    headers = public_headers()
    lines = [
        *("# C++ API", "", _NOTE, ""),
        "Everything that a program may include, header by header: what each declaration does, shapes, units and",
        "frames, and what is thrown. Everything is in `namespace srmp`, files of MoveIt and the library in `srmp::io`.",
        "",
        *(f"- [`{name}`](#{_anchor(name)})" for name in headers),
    ]
    for name, declarations in headers.items():
        lines += ["", f"## {name}"]
        for declaration in declarations:
            lines += _cpp_entry(declaration)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines) + "\n")


def _cpp_entry(declaration: Declaration) -> list[str]:
    if declaration.kind == "section":
        return []
    if declaration.kind not in ("class", "struct", "enum"):
        return ["", "```cpp", declaration.text, "```", "", declaration.doc]
    lines = ["", f"### {declaration.text}", "", declaration.doc]
    group = declaration.doc
    table = False
    for number, member in enumerate(declaration.members):
        if member.kind in ("field", "enumerator"):
            if not table:
                lines += ["", f"| {member.kind} | meaning |", "|---|---|"]
            lines.append(f"| `{_cell(member.text.rstrip(';'))}` | {_cell(member.doc)} |")
            table = True
            continue
        table = False
        if member.kind == "section":
            lines += ["", f"**{member.name[:1].upper()}{member.name[1:]}**"]
        elif member.kind in ("class", "struct", "enum"):
            lines += _cpp_entry(member)
        else:
            following = declaration.members[number + 1 : number + 2]
            shared = bool(following) and following[0].kind == "function" and following[0].doc == member.doc != ""
            opened = group == member.doc != ""
            lines += ([] if opened else ["", "```cpp"]) + [member.text]
            if not shared:
                lines += ["```", "", member.doc]
            group = member.doc if shared else ""
    return lines


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _anchor(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


# --- Python


def stub_file() -> Path:
    """The stubs of the built package's extension."""
    import srmp

    return Path(srmp.__file__).parent / "_srmp.pyi"


# Pages show the names that users import; None: all public names of the file.
MODULES = {
    "srmp": (
        ("_srmp.pyi", None),
        ("_verify.py", ("verify",)),
        ("_batch_planner.py", ("BatchPlanner", "Batch")),
        ("options.py", None),
        ("__init__.py", ("data_path", "get_cmake_dir")),
    ),
    "srmp.datasets": (
        ("datasets/generation.py", ("generate", "Generated")),
        ("datasets/spec.py", ("read_spec", "Spec")),
        ("datasets/scene.py", ("Scene", "SceneObject")),
        ("datasets/dataset.py", ("open", "Dataset", "Record")),
        ("datasets/audit.py", ("audit", "Audit", "Fault")),
        ("datasets/exporters/__init__.py", ("export",)),
    ),
    "srmp.sim": (
        ("sim/__init__.py", ("read_sim", "execute", "open_simulator")),
        ("sim/world.py", ("SimulatedWorld",)),
        ("sim/execution.py", ("Execution", "TouchEvent")),
        ("sim/parity.py", ("check_parity", "ParityReport", "Difference")),
        ("sim/simulator.py", ("MissingSimulator", "Simulator")),
    ),
    "srmp.robots": (
        ("robots/__init__.py", ("available", "find", "register")),
        ("robots/_list.py", ("Robot",)),
        ("robots/srdf.py", ("sample_allowed_collisions", "AllowedCollisions")),
    ),
    "srmp.compat.mplib": (
        ("compat/mplib.py", ("Planner",)),
        ("compat/_world.py", None),
        ("compat/_pose.py", ("Pose",)),
    ),
    "srmp.viewer": (("viewer/__init__.py", None), ("viewer/_server.py", ("Viewer",))),
    "srmp.plot": (("plot.py", None),),
}


def python_page(stubs: Path) -> str:
    """docs/api-python.md."""
    lines = [
        *("# Python API", "", _NOTE, ""),
        "All public names, module by module: what each does, shapes, units and frames, and what is raised. Arrays are",
        "NumPy's; `ArrayLike` is whatever NumPy can convert to one.",
        "",
        *(f"- [`{module}`](#{_anchor(module)})" for module in MODULES),
    ]
    for module, files in MODULES.items():
        entries = {}
        for file, names in files:
            text = (stubs if file == stubs.name else PACKAGE / file).read_text(encoding="utf-8")
            entries |= {
                node.name: (node, text.splitlines())
                for node in ast.parse(text).body
                if isinstance(node, ast.ClassDef | ast.FunctionDef)
                and (node.name in names if names else not node.name.startswith("_"))
            }
        lines += ["", f"## {module}"]
        ordered = sorted(entries.values(), key=lambda entry: (isinstance(entry[0], ast.FunctionDef), entry[0].name))
        prefix = "" if module == "srmp" else f"{module.rpartition('.')[2]}."  # srmp.Pose is not mplib.Pose
        names = [prefix + node.name for node, _ in ordered]
        lines += ["", ", ".join(f"[{name}](#{_anchor(name)})" for name in names)]
        for node, source in ordered:
            entry = _python_class(node, source) if isinstance(node, ast.ClassDef) else _python_function(node, "###")
            lines += [re.sub(r"^(#{3,4} )", rf"\1{prefix}", line) for line in entry]
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines) + "\n")


def _python_class(node: ast.ClassDef, source: list[str]) -> list[str]:
    lines = ["", f"### {node.name}", "", *_docstring(ast.get_docstring(node))]
    done: set[str] = set()
    rows = []
    for i, item in enumerate(node.body):
        if isinstance(item, ast.FunctionDef) and item.name == "__init__" and item.name not in done:
            done.add(item.name)
            lines += ["", "```py", _shown(item, node.name), "```", "", *_docstring(ast.get_docstring(item))]
        elif isinstance(item, ast.Assign | ast.AnnAssign):
            target = item.targets[0] if isinstance(item, ast.Assign) else item.target
            name = ast.unparse(target)
            following = node.body[i + 1] if i + 1 < len(node.body) else None
            comment = re.search(r"  #:? (.*)$", source[item.end_lineno - 1])
            text = comment[1] if comment else ""
            if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
                text = str(following.value.value)
            if not name.startswith("_"):
                shown = name if isinstance(item, ast.Assign) else f"{name}: {_type(item.annotation)}"
                rows.append((shown, text))
    if any(text for _, text in rows):
        lines += ["", "| value | meaning |", "|---|---|", *(f"| `{_cell(a)}` | {_cell(b)} |" for a, b in rows)]
    elif rows:
        lines += ["", "Fields: " + ", ".join(f"`{shown}`" for shown, _ in rows) + "."]
    properties = []
    for item in node.body:
        if not isinstance(item, ast.FunctionDef) or item.name.startswith("_") or item.name in done:
            continue
        done.add(item.name)
        if any(ast.unparse(decorator) == "property" for decorator in item.decorator_list):
            text = ast.get_docstring(item) or ""
            properties.append(f"| `{item.name}` | `{_cell(_type(item.returns))}` | {_cell(text)} |")
    if properties:
        lines += ["", "| property | type | meaning |", "|---|---|---|", *properties]
    for item in node.body:
        if isinstance(item, ast.FunctionDef) and not item.name.startswith("_"):
            decorators = [ast.unparse(decorator) for decorator in item.decorator_list]
            if not any(d == "property" or d.endswith(".setter") for d in decorators):
                lines += _python_function(item, "####", node.name)
    return lines


def _python_function(node: ast.FunctionDef, level: str, owner: str = "") -> list[str]:
    static = any(ast.unparse(decorator) == "staticmethod" for decorator in node.decorator_list)
    name = f"{owner}.{node.name}" if static else node.name
    head = f"{owner}.{node.name}" if owner else node.name
    return ["", f"{level} {head}", "", "```py", _shown(node, name), "```", "", *_docstring(ast.get_docstring(node))]


def _shown(node: ast.FunctionDef, name: str) -> str:
    """The signature, broken at its arguments where it is long; without self."""
    arguments = _arguments(node.args)
    result = "" if node.name == "__init__" or node.returns is None else f" -> {_type(node.returns)}"
    line = f"{name}({', '.join(arguments)}){result}"
    if len(line) <= 110:
        return line
    return "\n".join([f"{name}(", *(f"    {argument}," for argument in arguments), f"){result}"])


def _arguments(arguments: ast.arguments) -> list[str]:
    plain = [*arguments.posonlyargs, *arguments.args]
    defaults = [None] * (len(plain) - len(arguments.defaults)) + list(arguments.defaults)
    shown = [_argument(a, d) for a, d in zip(plain, defaults, strict=True) if a.arg != "self"]
    if arguments.vararg:
        shown.append(f"*{arguments.vararg.arg}")
    elif arguments.kwonlyargs:
        shown.append("*")
    shown += [_argument(a, d) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)]
    if arguments.kwarg:
        shown.append(f"**{arguments.kwarg.arg}")
    return shown


def _argument(argument: ast.arg, default: ast.expr | None) -> str:
    text = argument.arg if argument.annotation is None else f"{argument.arg}: {_type(argument.annotation)}"
    if default is None:
        return text
    return f"{text}{'=' if argument.annotation is None else ' = '}{ast.unparse(default)}"


def _type(annotation: ast.expr | None) -> str:
    """Without the modules that every reader knows."""
    text = "" if annotation is None else ast.unparse(annotation)
    text = re.sub(r"NDArray\[(?:numpy|np)\.(?:float64|void)\]|np\.ndarray", "ndarray", text)
    return re.sub(r"\b(?:numpy\.typing|collections\.abc|typing|srmp)\.", "", text)


def _docstring(text: str | None) -> list[str]:
    """Paragraphs; those that are laid out in columns stay so."""
    lines: list[str] = []
    for paragraph in (text or "").split("\n\n"):
        columns = re.search(r"\S  +\S", paragraph)
        lines += ["", "```text", paragraph, "```"] if columns else ["", paragraph]
    return lines[1:]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; 1 if a page is stale")
    check = parser.parse_args().check
    stale = []
    for path, text in ((CPP_PAGE, cpp_page()), (PYTHON_PAGE, python_page(stub_file()))):
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(path.name)
        if not check:
            path.write_text(text, encoding="utf-8")
    print(f"{'stale' if check else 'written'}: {', '.join(stale) or 'nothing'}")
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
