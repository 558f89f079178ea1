"""Contacts of a simulator, in the planner's names."""

from __future__ import annotations

from collections.abc import Iterable

from srmp.sim.simulator import Touch
from srmp.sim.world_view import WorldView

Pair = tuple[str, str]  # objects, and links as "robot/link"; sorted


def sorted_pair(a: str, b: str) -> Pair:
    """The two names as a pair, sorted."""
    return (a, b) if a < b else (b, a)


class ContactNames:
    """Shapes that the simulator does not tell apart in its contacts are one here, called as the first of them."""

    def __init__(self, world: WorldView) -> None:
        self._world = world
        known = world.names_of_keys()
        self._by_key = {key: min(names) for key, names in known.items()}
        self._groups = {min(names): names for names in known.values()}
        self._first = {name: min(names) for names in known.values() for name in names}

    def pair(self, a: str, b: str) -> Pair:
        """Of two of the planner's names."""
        return sorted_pair(self._first.get(a, a), self._first.get(b, b))

    def of_robots(self, touches: Iterable[Touch]) -> dict[Pair, float]:
        """Pairs with a link or what a robot holds, each with its largest depth [m]."""
        pairs: dict[Pair, float] = {}
        for touch in touches:
            a, b = self._by_key.get(touch.a), self._by_key.get(touch.b)
            if a and b and a != b and (self._world.is_of_robot(a) or self._world.is_of_robot(b)):
                pair = sorted_pair(a, b)
                pairs[pair] = max(pairs.get(pair, 0.0), touch.depth)
        return pairs

    def told_to_ignore(self, pair: Pair) -> bool:
        """Does the planner allow contact of any of the ones with any of the others?"""
        ones, others = (self._groups[name] for name in pair)
        return any(self._world.planner.allowed_collision(x, y) for x in ones for y in others)
