"""Words for sentences about what is not known."""

import difflib
from collections.abc import Iterable


def did_you_mean(name: object, known: Iterable[str], before: str = ", ", cutoff: float = 0.6) -> str:
    """The end of such a sentence, with the nearest name that there is; "" where none is near."""
    near = difflib.get_close_matches(str(name), list(known), n=1, cutoff=cutoff)
    return f"{before}did you mean '{near[0]}'?" if near else ""
