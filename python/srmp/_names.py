"""Suggestions for sentences about unknown names."""

from collections.abc import Iterable

from srmp import _srmp
from srmp._errors import one_sentence


def did_you_mean(name: object, known: Iterable[str], before: str = ", ") -> str:
    """The end of such a sentence, with the nearest known name; "" when none is near."""
    return _srmp._did_you_mean(one_sentence(str(name)), list(known)).replace(", ", before, 1)
