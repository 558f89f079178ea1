"""The sentence for a call of the library whose arguments have wrong types, are missing or have unknown names."""

from __future__ import annotations

import ast
import functools
import inspect
import operator
import os
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from srmp import _srmp
from srmp._authors_words import ARGUMENTS
from srmp._errors import one_sentence
from srmp._names import did_you_mean

_MAX_TEXT = 60  # characters of a value
_NAMES = {
    "str": "a string",
    "int": "a whole number",
    "float": "a number",
    "bool": "True or False",
    "None": "None",
    "dict": "a dictionary",
    "Mapping": "a dictionary",
    "Callable": "a function",
    "ArrayLike": "numbers",
    "NDArray": "numbers",
    "PathLike": "a path",
    "Path": "a path",
    "Any": "anything",
}
_LISTS = ("list", "Sequence")
_SURROGATE = re.compile("[\ud800-\udfff]")


class Parameter(NamedTuple):
    name: str
    type: ast.expr | None
    required: bool
    keyword_only: bool


def sentence(function: Any, args: Sequence[Any], keywords: Mapping[str, Any]) -> str:
    """What is wrong with the call function(*args, **keywords), which fits no signature of the function."""
    overloads = [_parameters(signature) for signature, *_ in function.__nb_signature__]
    name = _name(function)
    is_method = bool(overloads[0]) and overloads[0][0].name == "self"
    given = list(args)[1:] if is_method else list(args)
    faults = [_fault(name, parameters[1:] if is_method else parameters, given, keywords) for parameters in overloads]
    chosen = next((fault for fault in faults if fault.bound), faults[0])
    return f"{name}{chosen.text}"


def require_arguments(
    function: Callable[..., Any], name: str, args: Sequence[Any], keywords: Mapping[str, Any]
) -> None:
    """Raises WrongType where function(*args, **keywords) does not fit the signature of a function in Python."""
    parameters = _own_parameters(function)
    is_method = bool(parameters) and parameters[0].name == "self"
    name = name or _name(function)
    if fault := _misfit(name, parameters[is_method:], list(args)[is_method:], keywords):
        raise _srmp.WrongType(f"{name}{fault.text}")


def require_options(cls: type, args: Sequence[Any], keywords: Mapping[str, Any]) -> None:
    """Raises WrongType where a class of options has no such option; make_planner checks values, but not of 'robots'."""
    if cls.__module__ != "srmp.options":  # a user's class, which has arguments of its own
        return
    parameters = [
        parameter if parameter.name == "robots" else parameter._replace(type=None)
        for parameter in _own_parameters(cls.__init__)[1:]  # type: ignore[misc]
    ]
    if fault := _misfit(cls.__name__, parameters, args, keywords):
        raise _srmp.WrongType(f"{cls.__name__}{fault.text}")


class _Fault(NamedTuple):
    bound: bool  # every argument has its parameter
    text: str


def _fault(function: str, parameters: list[Parameter], args: Sequence[Any], keywords: Mapping[str, Any]) -> _Fault:
    if fault := _misfit(function, parameters, args, keywords):
        return fault
    values = {parameter.name: value for parameter, value in zip(parameters, args, strict=False)} | dict(keywords)
    for name, value in values.items():
        if not _is_utf8(value):
            return _Fault(True, f": {name} has characters that do not exist in UTF-8: {brief(value)}")
    expected = ", ".join(f"{parameter.name}: {_described(parameter.type)}" for parameter in parameters)
    got = ", ".join(brief(value) for value in values.values())
    return _Fault(True, f" takes ({expected}), but got ({got})")


def _misfit(
    function: str, parameters: list[Parameter], args: Sequence[Any], keywords: Mapping[str, Any]
) -> _Fault | None:
    positional = [parameter for parameter in parameters if not parameter.keyword_only]
    if len(args) > len(positional):
        named = [parameter.name for parameter in parameters if parameter.keyword_only]
        hint = f"; {_listed(named)} by name" if named else ""
        return _Fault(False, f" takes at most {len(positional)} arguments without a name, but got {len(args)}{hint}")
    values = {parameter.name: value for parameter, value in zip(positional, args, strict=False)}
    known = [parameter.name for parameter in parameters]
    for name, value in keywords.items():
        if name not in known:
            return _Fault(False, f" has no argument '{name}'{_hint(function, name, known)}")
        if name in values:
            return _Fault(False, f" got '{name}' twice")
        values[name] = value
    missing = [parameter.name for parameter in parameters if parameter.required and parameter.name not in values]
    if missing:
        return _Fault(False, f" needs {_listed(missing)}")
    for parameter in parameters:
        if parameter.name in values and not _fits(parameter.type, values[parameter.name]):
            value = brief(values[parameter.name])
            return _Fault(True, f": {parameter.name} must be {_described(parameter.type)}, but is {value}")
    return None


def _is_utf8(value: object) -> bool:
    """False for text, or texts in a list or dictionary, of which UTF-8 cannot encode a character."""
    if isinstance(value, Mapping):
        return all(_is_utf8(key) and _is_utf8(item) for key, item in value.items())
    if isinstance(value, (list, tuple)):
        return all(map(_is_utf8, value))
    return not isinstance(value, str) or not _SURROGATE.search(value)


def brief(value: object) -> str:
    """What Python would print, on one line of a sentence."""
    try:
        text = " ".join(repr(value).split())
    except Exception:
        text = f"a {type(value).__name__}"
    return text if len(text) <= _MAX_TEXT else text[:_MAX_TEXT] + " …"


def _name(function: Any) -> str:
    """As users write it: add_box, or Pose for its constructor."""
    *owner, name = function.__qualname__.split(".")
    return owner[-1] if name == "__init__" and owner else name


def _hint(function: str, name: str, known: list[str]) -> str:
    if theirs := ARGUMENTS.get((function, name)):
        return f"; {theirs}"
    if theirs := _srmp._option_of_other_planner(one_sentence(name)):
        return f"; {theirs}, an option of make_planner" if theirs.startswith("it is '") else f"; {theirs}"
    return did_you_mean(name, known) or (f"; it takes {_listed(known)}" if known else "; it takes none")


def _listed(names: Sequence[str]) -> str:
    quoted = [f"'{name}'" for name in names]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} and {quoted[-1]}"


# --- signatures: "def f(self, a: str, *, b: float = \\0) -> None" -----------------------------------------------------


def _parameters(signature: str) -> list[Parameter]:
    text = re.sub(r"\\\d+", "...", signature)
    (function,) = ast.parse(text + ": ...").body
    assert isinstance(function, ast.FunctionDef)
    arguments = function.args
    positional = [*arguments.posonlyargs, *arguments.args]
    defaults = [False] * (len(positional) - len(arguments.defaults)) + [True] * len(arguments.defaults)
    parameters = [Parameter(a.arg, a.annotation, not has, False) for a, has in zip(positional, defaults, strict=True)]
    for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True):
        parameters.append(Parameter(argument.arg, argument.annotation, default is None, True))
    return parameters


@functools.cache
def _own_parameters(function: Callable[..., Any]) -> list[Parameter]:
    """Of a function in Python, whose annotations are texts."""
    return [
        Parameter(
            parameter.name,
            ast.parse(parameter.annotation, mode="eval").body if isinstance(parameter.annotation, str) else None,
            parameter.default is parameter.empty,
            parameter.kind is parameter.KEYWORD_ONLY,
        )
        for parameter in inspect.signature(function).parameters.values()
    ]


def _parts(type_: ast.expr) -> tuple[str, list[ast.expr]]:
    """The last name of a type and what stands in its brackets: ("Mapping", [str, float])."""
    inside: list[ast.expr] = []
    if isinstance(type_, ast.Subscript):
        inside = list(type_.slice.elts) if isinstance(type_.slice, ast.Tuple) else [type_.slice]
        type_ = type_.value
    if isinstance(type_, ast.Constant):
        return str(type_.value), inside
    return ast.unparse(type_).split(".")[-1], inside


def _fits(type_: ast.expr | None, value: object) -> bool:
    """False only where the value certainly has another type."""
    if type_ is None:
        return True
    if isinstance(type_, ast.BinOp):
        return _fits(type_.left, value) or _fits(type_.right, value)
    name, inside = _parts(type_)
    checks: dict[str, Callable[[], bool]] = {
        "str": lambda: isinstance(value, str),
        "int": lambda: _is_index(value),
        "float": lambda: hasattr(value, "__float__") or hasattr(value, "__index__"),
        "bool": lambda: type(value).__name__ in ("bool", "bool_"),  # NumPy's has either name
        "None": lambda: value is None,
        "dict": lambda: isinstance(value, dict),
        "Callable": lambda: callable(value),
        "ArrayLike": lambda: value is not None,
        "NDArray": lambda: value is not None,
        "PathLike": lambda: isinstance(value, (str, os.PathLike)),
        "Path": lambda: isinstance(value, (str, os.PathLike)),
        "Mapping": lambda: isinstance(value, Mapping),
    }
    if name in _LISTS:
        return _is_list(value) and all(_fits(inside[0], item) for item in value) if inside else _is_list(value)
    if name in ("Mapping", "dict") and len(inside) == 2:
        return isinstance(value, Mapping) and all(
            _fits(inside[0], key) and _fits(inside[1], item) for key, item in value.items()
        )
    if name in checks:
        return checks[name]()
    cls = getattr(_srmp, name, None)
    return isinstance(value, cls) if isinstance(cls, type) else True


def _is_index(value: object) -> bool:
    try:
        operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return False
    return True


def _is_list(value: object) -> bool:
    return hasattr(value, "__getitem__") and hasattr(value, "__len__") and not isinstance(value, (str, bytes, Mapping))


def _described(type_: ast.expr | None) -> str:
    if type_ is None:
        return "anything"
    if isinstance(type_, ast.BinOp):
        return " or ".join(dict.fromkeys([_described(type_.left), *_described(type_.right).split(" or ")]))
    name, inside = _parts(type_)
    if name in _LISTS:
        return f"a list ({_described(inside[0])} each)" if inside else "a list"
    if name in ("dict", "Mapping") and len(inside) == 2:
        return f"a dictionary ({_described(inside[1])} by {_described(inside[0]).removeprefix('a ')})"
    return _NAMES.get(name, f"a {name}")
