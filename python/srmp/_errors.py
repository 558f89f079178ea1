"""Errors of functions in Python read as those of C++: one line, below 500 characters, for arguments of any type."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from typing import Any, TypeVar

from srmp import _srmp

_Function = TypeVar("_Function", bound=Callable[..., Any])
_LONGEST, _FRONT, _BACK = 499, 300, 190  # characters
_LINE_BREAKS = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029]+")  # these are all control characters


def one_sentence(text: str) -> str:
    """The text on one line, without its middle where it is too long; what UTF-8 cannot encode is escaped."""
    line = _LINE_BREAKS.sub(" ", text.encode("utf-8", "backslashreplace").decode())
    return line if len(line) <= _LONGEST else f"{line[:_FRONT]} … {line[-_BACK:]}"


def shorten_error_texts() -> None:
    """Every srmp.Error makes one sentence of its text, wherever it is raised."""

    def __init__(self: _srmp.Error, *args: object) -> None:
        shortened = (one_sentence(value) if isinstance(value, str) else value for value in args)
        super(_srmp.Error, self).__init__(*shortened)

    _srmp.Error.__init__ = __init__  # type: ignore[assignment, method-assign]


def checked(function: _Function, name: str = "") -> _Function:
    """The function, which raises WrongType where arguments have the wrong type, are missing or are not known.

    name: as users know it, where that is another.
    """

    @functools.wraps(function)
    def call(*args: Any, **keywords: Any) -> Any:
        from srmp import _wrong_types  # here, because what it imports would slow down import srmp

        _wrong_types.require_arguments(function, name, args, keywords)
        return function(*args, **keywords)

    return call  # type: ignore[return-value]
