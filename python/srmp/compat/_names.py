"""Errors for unknown names and bad numbers, in one sentence with the nearest known name."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import srmp
from srmp._names import did_you_mean

_T = TypeVar("_T")


def refuses_unknown(cls: type[_T]) -> type[_T]:
    """Public calls refuse unknown keywords with the nearest; **options are those that cls._options names."""

    def checked(call: Callable[..., Any]) -> Callable[..., Any]:
        signature = inspect.signature(call)
        known = [name for name in signature.parameters if name != "self"]
        if "options" in known:
            known = list(dict.fromkeys([*known[:-1], *cls._options]))  # type: ignore[attr-defined]

        @functools.wraps(call)
        def refuse_unknown(*args: Any, **keywords: Any) -> Any:
            for name in keywords:
                if name not in known:
                    raise srmp.WrongType(f"{call.__qualname__} has no argument '{name}'{nearest(name, known)}")
            try:
                signature.bind(*args, **keywords)
            except TypeError as error:
                raise srmp.WrongType(f"{call.__qualname__}: {error}") from None
            return call(*args, **keywords)

        return refuse_unknown

    for name, call in list(vars(cls).items()):
        if inspect.isfunction(call) and (name == "__init__" or not name.startswith("_")):
            setattr(cls, name, checked(call))
    return cls


def nearest(name: str, known: Iterable[str]) -> str:
    """The end of a sentence about an unknown name."""
    known = list(known)
    return did_you_mean(name, known) or f"; there are {', '.join(known) or 'none'}"


def require_known(argument: str, names: Sequence[str], known: Iterable[str]) -> None:
    """Raises InvalidArgument for names that the robot has not, or that are there twice."""
    known = list(known)
    for name in names:
        if name not in known:
            raise srmp.InvalidArgument(f"{argument} has '{name}', which the robot has not{nearest(name, known)}")
    if len(set(names)) != len(names):
        raise srmp.InvalidArgument(f"{argument} names something twice: {', '.join(names)}")


def require_positive(**values: float) -> None:
    """Raises InvalidArgument for numbers that are not above 0 and finite."""
    for name, value in values.items():
        if not 0 < value < math.inf:
            raise srmp.InvalidArgument(f"{name} is {value}; it must be above 0 and finite")
