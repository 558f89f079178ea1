"""Reads the fields of a spec one by one: every refusal names the field, its value, and what is allowed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import srmp
from srmp._names import did_you_mean


class Fields:
    """The fields of a mapping; `close` refuses those that nobody asked for."""

    def __init__(self, values: Any, where: str = "") -> None:
        """where: the path of the mapping in the spec, such as "robots[0]"; "" for the spec itself."""
        self._where = where
        if not isinstance(values, Mapping):
            raise self.refusal("", values, "a mapping of names to values")
        self._values = dict(values)
        self._known: list[str] = []

    def refusal(self, key: str, value: Any, allowed: str) -> srmp.InvalidArgument:
        """The error that says what the field was and what is allowed."""
        name = ".".join(part for part in (self._where, key) if part) or "the spec"
        return srmp.InvalidArgument(f"{name} is {value!r}; it must be {allowed}.")

    def has(self, key: str) -> bool:
        """Whether the field is there."""
        self._known.append(key)
        return key in self._values

    def any(self, key: str, default: Any = None, *, required: bool = False) -> Any:
        """The value as it is."""
        if self.has(key):
            return self._values[key]
        if required:
            raise srmp.InvalidArgument(f"{self._where or 'the spec'} has no '{key}'.")
        return default

    def text(self, key: str, default: str | None = None, choices: Sequence[str] = ()) -> str:
        """A text; required where there is no default."""
        value = self.any(key, default, required=default is None)
        if not isinstance(value, str) or (not value and default is None):
            raise self.refusal(key, value, "a text")
        if choices and value not in choices:
            hint = did_you_mean(value, choices) or "."
            raise srmp.InvalidArgument(
                f"{'.'.join(filter(None, (self._where, key)))} is '{value}'; it must be one of "
                f"{', '.join(choices)}{hint}"
            )
        return value

    def number(self, key: str, default: float | None = None, least: float = -math.inf, most: float = math.inf) -> float:
        """A finite number within bounds."""
        value = self.any(key, default, required=default is None)
        good = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
        if not good or not least <= value <= most:
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
        if not all(isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x) for x in value):
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
        return [Fields(item, f"{self._where}.{key}[{k}]".lstrip(".")) for k, item in enumerate(value)]

    def inner(self, key: str) -> Fields | None:
        """The fields of a mapping; None where it is not there."""
        return Fields(self._values[key], f"{self._where}.{key}".lstrip(".")) if self.has(key) else None

    def close(self) -> None:
        """Refuses fields that are not known."""
        for key in self._values:
            if key not in self._known:
                hint = did_you_mean(str(key), self._known) or f"; known: {', '.join(dict.fromkeys(self._known))}."
                raise srmp.InvalidArgument(f"{self._where or 'the spec'} has an unknown field '{key}'{hint}")


def _range(least: float, most: float) -> str:
    if math.isinf(most):
        return "" if math.isinf(least) else f" of at least {least:g}"
    return f" from {least:g} to {most:g}"
