"""Writes everything that repeats the registry of planner options (src/srmp/planning/options/registry.cpp).

That is python/srmp/options.py as a whole, the tables between markers in docs/planners.md, and the comments of the
structs in include/srmp/planning/options.hpp. Run it with a built package after a change of the registry:

    python docs/generate_options.py

A test compares the files with what this program would write.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable
from pathlib import Path

import srmp

ROOT = Path(__file__).resolve().parents[1]
HEADER = ROOT / "include" / "srmp" / "planning" / "options.hpp"
MODULE = ROOT / "python" / "srmp" / "options.py"
PAGE = ROOT / "docs" / "planners.md"
WIDTH = 120
NO_BREAK = "\a"  # in place of a space


def filled(text: str, first: str, others: str) -> str:
    """Lines no longer than WIDTH, with what they begin with."""
    lines = textwrap.fill(
        text, WIDTH, initial_indent=first, subsequent_indent=others, break_long_words=False, break_on_hyphens=False
    )
    return lines.replace(NO_BREAK, " ")


def planners() -> list[srmp.PlannerInfo]:
    return [srmp.planner_info(planner_id) for planner_id in srmp.available_planners()]


def common_options() -> list[srmp.OptionInfo]:
    return [option for option in planners()[0].options if option.common]


def own_options(planner: srmp.PlannerInfo) -> list[srmp.OptionInfo]:
    return [option for option in planner.options if not option.common]


def meaning(option: srmp.OptionInfo) -> str:
    """The sentence, with unit and allowed values in brackets that filled() keeps in one line."""
    allowed = option.range or " | ".join(option.choices)
    facts = ", ".join(fact for fact in (option.unit, allowed) if fact).replace(" ", NO_BREAK)
    return option.description.removesuffix(".") + (f" [{facts}]." if facts else ".")


def sentence(text: str) -> str:
    return text[0].upper() + text[1:] + "."


# --- python/srmp/options.py -------------------------------------------------------------------------------------------

MODULE_HEAD = '''"""Planner options with types: `planner.make_planner("panda", srmp.WAStar(weight=10))`.

Each class holds the options of one planner, with the library's defaults; units and ranges stand in brackets.

docs/generate_options.py writes this file from the registry of options in the library: change the registry, not the
file.
"""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, TypeVar

__all__ = [
{names}
]
_Class = TypeVar("_Class")


@dataclasses.dataclass(kw_only=True)
class _Options:
    """Options that every planner has."""

    planner_id: ClassVar[str]

{fields}

    def __new__(cls: type[_Class], *args: Any, **options: Any) -> _Class:
        """Raises WrongType, with the nearest name, for an option that the planner does not have."""
        from srmp._wrong_types import require_options

        require_options(cls, args, options)
        return super().__new__(cls)  # type: ignore[misc]

    def to_dict(self) -> dict[str, Any]:
        """The dictionary with the same options. Raises WrongType where an attribute was set to what is no option."""
        from srmp._wrong_types import require_options

        options = dataclasses.asdict(self)
        require_options(type(self), (), options)
        for robot, own in options.pop("robots", {{}}).items():
            options |= {{f"{{key}}_{{robot}}": value for key, value in own.items()}}
        return {{"planner_id": self.planner_id, **options}}
'''

MODULE_CLASS = """

@dataclasses.dataclass(kw_only=True)
class {name}(_Options):
{docstring}

    planner_id: ClassVar[str] = "{id}"
"""


def quoted(value: object) -> str:
    """As ruff has it."""
    return repr(value).replace("'", '"')


def docstring(paragraphs: Iterable[str]) -> str:
    """Indented for the body of a class; on one line where it fits."""
    parts = [filled(text, "    " if number else '    """', "    ") for number, text in enumerate(paragraphs)]
    text = "\n\n".join(parts)
    many_lines = len(parts) > 1 or len(text.splitlines()[-1]) + 3 > WIDTH
    return text + ("\n    " if many_lines else "") + '"""'


def module_field(option: srmp.OptionInfo) -> str:
    if isinstance(option.default, list):
        line = f"    {option.name}: {option.type} = dataclasses.field(default_factory=lambda: {quoted(option.default)})"
        if len(line) > WIDTH:
            line = line.replace("field(", "field(\n        ")[:-1] + "\n    )"
    else:
        line = f"    {option.name}: {option.type} = {quoted(option.default)}"
    return f"{line}\n{docstring([meaning(option)])}"


def robots_field(options: Iterable[srmp.OptionInfo]) -> str:
    names = " and ".join(f"`{option.name}`" for option in options if option.per_robot)
    return (
        "    robots: dict[str, dict[str, str]] = dataclasses.field(default_factory=dict)\n"
        f'    """With many robots: {names} of single robots, by name, in place of those for all."""'
    )


def module_text(_: str) -> str:
    names = sorted((planner.class_name for planner in planners()), key=lambda name: (not name.isupper(), name))
    text = MODULE_HEAD.format(
        names="\n".join(f'    "{name}",' for name in names),
        fields="\n".join(module_field(option) for option in common_options()),
    )
    for planner in planners():
        fields = [robots_field(planner.options)] if any(option.per_robot for option in planner.options) else []
        fields += [module_field(option) for option in own_options(planner)]
        text += MODULE_CLASS.format(name=planner.class_name, id=planner.id, docstring=docstring(about(planner)))
        text += "".join(f"{field}\n" for field in fields)
    return text


def about(planner: srmp.PlannerInfo) -> list[str]:
    """The paragraphs of the documentation of a planner's class."""
    return [
        sentence(planner.summary),
        f"Literature: {planner.papers}.",
        f"Guarantee: {planner.guarantee}.",
    ]


# --- include/srmp/planning/options.hpp --------------------------------------------------------------------------------


def comment(text: str, indent: str) -> str:
    return filled(text, f"{indent}/// ", f"{indent}/// ") + "\n"


def with_field_comments(body: str, options: Iterable[srmp.OptionInfo]) -> str:
    """The fields of a struct with the registry's sentences above them."""
    body = re.sub(r"^ *///.*\n", "", body, flags=re.MULTILINE)
    for option in options:
        body, found = re.subn(
            rf"^  [^\n]*\b{option.name}\{{",
            lambda line, option=option: comment(meaning(option), "  ") + line[0],
            body,
            flags=re.MULTILINE,
        )
        if found != 1:
            raise ValueError(f"{HEADER.name} has {found} fields '{option.name}' where there should be one")
    return body


def with_struct_comments(text: str, name: str, documentation: str, options: Iterable[srmp.OptionInfo]) -> str:
    """The header with comments of one struct; without `documentation` the struct's own comment stays."""
    before, found, after = text.partition(f"\nstruct {name} {{\n")
    if not found:
        raise ValueError(f"{HEADER.name} has no struct '{name}'")
    if documentation:
        lines = before.split("\n")
        while lines[-1].startswith("///"):
            lines.pop()
        before = "\n".join([*lines, documentation.rstrip("\n")])
    body, end, after = after.partition("\n};\n")
    return before + found + with_field_comments(body, options) + end + after


def header_text(text: str) -> str:
    text = with_struct_comments(text, "CommonOptions", "", common_options())
    for planner in planners():
        documentation = "".join(comment(paragraph, "") for paragraph in about(planner))
        text = with_struct_comments(text, planner.class_name, documentation, own_options(planner))
    return text


# --- docs/planners.md -------------------------------------------------------------------------------------------------


def cell(text: str) -> str:
    return text.replace(" * ", " · ").replace("<=", "≤").replace(">=", "≥").replace("|", "\\|")


def row(*cells: str) -> str:
    return re.sub(" +", " ", f"| {' | '.join(cells)} |") + "\n"


def table(*head: str) -> str:
    return row(*head) + "|" + "---|" * len(head) + "\n"


def shown(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return value or '""'
    return quoted(value)


def option_row(option: srmp.OptionInfo) -> str:
    allowed = option.range or ", ".join(f"`{choice}`" for choice in option.choices)
    return row(f"`{option.name}`", shown(option.default), option.unit, cell(allowed), cell(option.description))


def planner_table(chosen: Iterable[srmp.PlannerInfo], guarantee: str) -> str:
    return table("id", "class", "paper", guarantee) + "".join(
        row(f"`{planner.id}`", f"`{planner.class_name}`", cell(planner.papers), cell(planner.guarantee))
        for planner in chosen
    )


OPTION_HEAD = ("option", "default", "unit", "range", "meaning")


def page_parts() -> dict[str, str]:
    """The tables of the page, by the names in its markers."""
    own = "".join(
        row(f"**`{planner.id}`**", "", "", "", "") + "".join(option_row(option) for option in own_options(planner))
        for planner in planners()
        if own_options(planner)
    )
    return {
        "planners of one robot": planner_table((p for p in planners() if p.one_robot), "guarantee"),
        "planners of many robots only": planner_table((p for p in planners() if not p.one_robot), "guarantee"),
        "options of every planner": table(*OPTION_HEAD) + "".join(option_row(option) for option in common_options()),
        "options of one planner": table(*OPTION_HEAD) + own,
    }


def page_text(text: str) -> str:
    for name, part in page_parts().items():
        begin, end = f"<!-- generated: {name} -->\n", "<!-- end -->\n"
        before, found, after = text.partition(begin)
        if not found or end not in after:
            raise ValueError(f"{PAGE.name} has no markers for '{name}'")
        text = before + begin + "\n" + part + "\n" + end + after.partition(end)[2]
    return text


# ----------------------------------------------------------------------------------------------------------------------

GENERATED: dict[Path, Callable[[str], str]] = {MODULE: module_text, HEADER: header_text, PAGE: page_text}


def main() -> None:
    for path, generate in GENERATED.items():
        before = path.read_text(encoding="utf-8")
        after = generate(before)
        if after != before:
            path.write_text(after, encoding="utf-8")
            print(f"wrote {path.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
