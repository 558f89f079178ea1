"""Writes docs/api-cpp.md from the headers in include/srmp, and docs/api-python.md from the stubs of the built package.

    python docs/make_api_reference.py           writes both pages; the package srmp must be importable
    python docs/make_api_reference.py --check   says which page is stale and ends with 1

The headers are read line by line, which suffices for the way they are written: a contract is a `///` comment above its
declaration or a `///<` comment behind it, and clang-format has put every declaration on lines of its own.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HEADERS = ROOT / "include" / "srmp"
CPP_PAGE = ROOT / "docs" / "api-cpp.md"
PYTHON_PAGE = ROOT / "docs" / "api-python.md"

# --- C++


@dataclass
class Declaration:
    """One public declaration of a header."""

    kind: str  # "class", "struct", "enum", "function", "field", "enumerator" or "alias"
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
                doc.append(line[3:].strip())
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
        into.extend(_declarations(text, " ".join(doc + trailing), first + 1, scope))

    def _open(
        self, into: list[Declaration], scope: str, opened: re.Match[str], text: str, doc: list[str], first: int
    ) -> None:
        kind, name = opened[1], opened[2] or ""
        if kind == "namespace":
            self._read_scope(into, scope, "namespace", True)
            return
        head = text.removesuffix("{").strip()
        declaration = Declaration(kind.split()[0], name, head, _paragraphs(doc), first + 1, scope)
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
            into.append(Declaration("enumerator", name, name, " ".join(doc + trailing), line, scope))


def _paragraphs(doc: list[str]) -> str:
    return "\n".join(doc).strip()


def _declarations(text: str, doc: str, line: int, scope: str) -> list[Declaration]:
    """One, or the several fields that a line such as `double from{}, to{};` declares; none for what needs no words."""
    text = re.sub(r"\s+", " ", text)
    if _needs_no_words(text, scope):
        return []
    if text.startswith("using "):
        name = text.split()[1]
        return [Declaration("alias", name, text, doc, line, scope)]
    head = re.sub(r"<[^()]*>", "", text)
    is_function = "(" in head.split("{")[0].split("=")[0] or "operator" in text
    if is_function:
        match = re.search(r"(operator\s*\S+?|~?\w+)\s*\(", head)
        signature = re.sub(r"\s*(\{.*\}|: \w+\(.*)$", ";", text) if "{" in text.split(")")[-1] else text
        return [Declaration("function", match[1] if match else text, signature, doc, line, scope)]
    names = re.findall(r"(\w+)\s*(?:\{[^{}]*(?:\{[^{}]*\}[^{}]*)*\}|=[^,;]*)?\s*[,;]", head)
    return [Declaration("field", names[0] if names else text, text, doc, line, scope)]


def _needs_no_words(text: str, scope: str) -> bool:
    """Forward declarations, friends, and the constructors, destructors and assignments that say nothing of their own."""
    if re.match(r"^(template <.*> )?(class|struct|enum class|union) [\w:]+;$", text) or text.startswith(("friend ", "extern template")):
        return True
    if re.match(r"^using [\w:]+;$", text) or text in (";", "};"):
        return True
    name = scope.split("::")[-1]
    own = rf"^(explicit |constexpr |inline )*~?{re.escape(name)}\(" if name else r"^$"
    return bool(re.match(own, text)) or "operator=(" in text.replace(" ", "") or "operator==" in text


def _share_docs_of_overloads(declarations: list[Declaration]) -> None:
    """An overload without words of its own has those of the one just before it."""
    for before, after in zip(declarations, declarations[1:], strict=False):
        if not after.doc and after.kind == before.kind == "function" and after.name == before.name:
            after.doc = before.doc
