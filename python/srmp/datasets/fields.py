"""Reads the fields of a spec one by one: every refusal names the field, its value, and what is allowed."""

from __future__ import annotations

import contextlib
import math
import reprlib
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import srmp
from srmp._names import did_you_mean


def short(value: Any) -> str:
    """A value as a message shows it: on one line, and not all of a long one."""
    shown = reprlib.Repr()
    shown.maxstring = shown.maxother = shown.maxlong = 80
    return shown.repr(value)


def is_number(value: Any) -> bool:
    """A finite number that is a double; not True or False."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


class Fields:
    """The fields of a mapping; `close` refuses those that nobody asked for."""

    def __init__(self, values: Any, where: str = "") -> None:
        """where: the path of the mapping in the spec, such as "robots[0]"; "" for the spec itself."""
        self.where = where
        """The path of the mapping in the spec."""
        if not isinstance(values, Mapping):
            raise self.refusal("", values, "a mapping of names to values")
        self._values = dict(values)
        self._known: list[str] = []

    def refusal(self, key: str, value: Any, allowed: str) -> srmp.InvalidArgument:
        """The error that says what the field was and what is allowed."""
        name = ".".join(part for part in (self.where, key) if part) or "the spec"
        return srmp.InvalidArgument(f"{name} is {short(value)}; it must be {allowed}.")

    def has(self, key: str) -> bool:
        """Whether the field is there."""
        self._known.append(key)
        return key in self._values

    def any(self, key: str, default: Any = None, *, required: bool = False) -> Any:
        """The value as it is."""
        if self.has(key):
            return self._values[key]
        if required:
            raise srmp.InvalidArgument(f"{self.where or 'the spec'} has no '{key}'.")
        return default

    def text(self, key: str, default: str | None = None, choices: Sequence[str] = ()) -> str:
        """A text; required where there is no default."""
        value = self.any(key, default, required=default is None)
        if not isinstance(value, str) or (not value and default is None):
            raise self.refusal(key, value, "a text")
        if choices and value not in choices:
            hint = did_you_mean(value, choices) or "."
            raise srmp.InvalidArgument(
                f"{'.'.join(filter(None, (self.where, key)))} is {short(value)}; it must be one of "
                f"{', '.join(choices)}{hint}"
            )
        return value

    def number(self, key: str, default: float | None = None, least: float = -math.inf, most: float = math.inf) -> float:
        """A finite number within bounds."""
        value = self.any(key, default, required=default is None)
        if not is_number(value) or not least <= value <= most:
            raise self.refusal(key, value, f"a number{_range(least, most)}")
        return float(value)

    def whole(self, key: str, default: int | None = None, least: int = 0, most: float = math.inf) -> int:
        """A whole number within bounds."""
        value = self.any(key, default, required=default is None)
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            raise self.refusal(key, value, f"a whole number{_range(least, most)}")
        return value

    def numbers(self, key: str, count: int | None, default: Sequence[float] | None = None) -> tuple[float, ...]:
        """A list of finite numbers."""
        value = self.any(key, default, required=default is None)
        what = f"{count} finite numbers" if count else "a list of finite numbers"
        if not isinstance(value, Sequence) or isinstance(value, str) or (count and len(value) != count):
            raise self.refusal(key, value, what)
        if not all(map(is_number, value)):
            raise self.refusal(key, value, what)
        return tuple(float(x) for x in value)

    def wholes(self, key: str) -> tuple[int, ...]:
        """A set of whole numbers, sorted; empty by default."""
        value = self.any(key, [])
        whole = isinstance(value, Sequence) and all(type(x) is int and 0 <= x < 2**63 for x in value)
        if not whole or isinstance(value, str):
            raise self.refusal(key, value, "a list of whole numbers of at least 0")
        return tuple(sorted(set(value)))

    def texts(self, key: str, default: Sequence[str] = ()) -> tuple[str, ...]:
        """A list of texts."""
        value = self.any(key, list(default))
        if not isinstance(value, Sequence) or isinstance(value, str) or not all(isinstance(x, str) for x in value):
            raise self.refusal(key, value, "a list of texts")
        return tuple(value)

    def file(self, key: str, directory: Path) -> Path:
        """A file that exists; relative paths begin at the directory."""
        path = directory / self.text(key)
        with contextlib.suppress(OSError, ValueError):  # a name that is too long, or holds a NUL
            if path.is_file():
                return path
        raise self.refusal(key, str(path), "a file that exists")

    def mapping(self, key: str) -> dict[str, Any]:
        """A mapping, empty by default."""
        value = self.any(key, {})
        if not isinstance(value, Mapping):
            raise self.refusal(key, value, "a mapping of names to values")
        return {str(name): item for name, item in value.items()}

    def items(self, key: str) -> list[Fields]:
        """A list of mappings, at least one."""
        value = self.any(key, required=True)
        if not isinstance(value, Sequence) or isinstance(value, str) or not value:
            raise self.refusal(key, value, "a list of at least one mapping")
        return [Fields(item, f"{self.where}.{key}[{k}]".lstrip(".")) for k, item in enumerate(value)]

    def inner(self, key: str) -> Fields | None:
        """The fields of a mapping; None where it is not there."""
        return Fields(self._values[key], f"{self.where}.{key}".lstrip(".")) if self.has(key) else None

    def close(self) -> None:
        """Refuses fields that are not known."""
        for key in self._values:
            if key not in self._known:
                hint = did_you_mean(str(key), self._known) or f"; known: {', '.join(dict.fromkeys(self._known))}."
                raise srmp.InvalidArgument(f"{self.where or 'the spec'} has an unknown field {short(key)}{hint}")


def _range(least: float, most: float) -> str:
    if math.isinf(most):
        return "" if math.isinf(least) else f" of at least {least:g}"
    return f" from {least:g} to {most:g}"
