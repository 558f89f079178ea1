"""Arguments of calls, mostly valid ones, and changes of texts: the same for the same seed on every machine."""

import random
from pathlib import Path

import numpy as np

import srmp

LIMIT = "<limit lower='-3' upper='3' velocity='2' effort='1'/>"
NUMBERS = [0, 1, -1, 0.1, 0.5, 2, 1e-300, 1e-160, 1e-9, 1e3, 1e4, 1e20, 1e160, 1e308, float("nan"), float("inf"), 2**70]
WORDS = ["", "arm", "box", "lower", "arm/lower", "a", "no", "\0", "\udc80", "\n", "x" * 2000, "桌子", "..", "auto"]
HOSTILE = [b"0", b"-1", b"1e308", b"1e-160", b"nan", b".inf", b"2147483648", b"18446744073709551616", b"1.5", b"null"]
HOSTILE += [
    b"true",
    b"[]",
    b"{}",
    b'""',
    b"<",
    b"\xff",
    b"\xed\xa0\x80",
    b"../..",
    b"/dev/null",
    b"\n",
    b"  ",
    b"&a",
    b"*a",
]


def bar(name):
    return (
        f"<link name='{name}'><collision><origin xyz='0.25 0 0'/><geometry><box size='0.4 0.05 0.05'/></geometry>"
        "</collision></link>"
    )


def joint(name, parent, child, x, kind="revolute", limit=LIMIT):
    return (
        f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>"
        f"<origin xyz='{x} 0 0'/><axis xyz='0 0 1'/>{limit}</joint>"
    )


URDF = (
    f"<robot name='planar'><link name='base'/>{bar('upper')}{bar('lower')}"
    f"{joint('a', 'base', 'upper', 0)}{joint('b', 'upper', 'lower', 0.5)}</robot>"
)
URDF3 = (
    f"<robot name='planar3'><link name='base'/>{bar('upper')}{bar('middle')}{bar('lower')}"
    "<link name='finger'><collision><geometry><sphere radius='0.02'/></geometry></collision></link>"
    f"{joint('a', 'base', 'upper', 0)}{joint('b', 'upper', 'middle', 0.5)}{joint('c', 'middle', 'lower', 0.5)}"
    f"{joint('f', 'lower', 'finger', 0.5, 'prismatic', LIMIT.replace('3', '0.1'))}</robot>"
)


class Nasty:
    """An object whose every conversion fails."""

    def fail(self, *_):
        raise TypeError("nasty")

    __array__ = __float__ = __len__ = __iter__ = __fspath__ = fail


class Maker:
    """Makes arguments: mostly valid ones."""

    def __init__(self, seed, directory: Path, hostile=0.2):
        self.random = random.Random(seed)
        self.directory = directory
        self.hostile = hostile

    def chance(self, probability):
        return self.random.random() < probability

    def number(self):
        return self.random.choice(NUMBERS) if self.chance(self.hostile) else round(self.random.uniform(-3, 3), 3)

    def length(self):
        return self.random.choice(NUMBERS) if self.chance(self.hostile) else round(self.random.uniform(0.01, 1), 3)

    def numbers(self, count):
        if self.chance(self.hostile / 2):
            count = self.random.randrange(5)
        return [self.number() for _ in range(count)]

    def rows(self, count, columns):
        rows = [self.numbers(columns) for _ in range(self.random.randrange(count + 1))]
        return rows if self.chance(0.9) else self.anything()

    def name(self, *known):
        return self.random.choice(WORDS if self.chance(self.hostile) else known)

    def pose(self):
        return srmp.Pose(p=self.numbers(3)) if self.chance(0.8) else srmp.Pose(self.numbers(3), self.numbers(4))

    def anything(self):
        return self.random.choice(
            [
                None,
                True,
                1,
                1e300,
                "x",
                "\udc80",
                b"\xff",
                [],
                {},
                (),
                [[1], [1, 2]],
                {"a": 1},
                np.zeros((2, 0)),
                Nasty(),
                np.array(["a"]),
                np.array([1j]),
                np.zeros((1, 1, 1)),
                object(),
                srmp.Pose(),
                srmp.GoalConstraint.hold(),
            ]
        )

    def goal(self):
        kind = self.random.randrange(5)
        if kind == 0:
            return srmp.GoalConstraint.hold()
        if kind == 1:
            return srmp.GoalConstraint(srmp.GoalType.POSE, self.pose())
        if kind == 2:
            return srmp.GoalConstraint(srmp.GoalType.POSITION, self.numbers(3))
        return srmp.GoalConstraint(srmp.GoalType.JOINTS, self.numbers(2))

    def options(self):
        options = {"planner_id": self.name("auto", "wAstar", "ARAstar", "RRTConnect"), "time_limit": 0.05}
        for _ in range(self.random.randrange(3)):
            key = self.name("weight", "improve_rounds", "resolution", "time_limit", "sample_period", "certify")
            options[key] = self.random.choice([self.number(), self.name("true", "1e300"), self.anything()])
        if isinstance(options["time_limit"], (int, float, str)):  # a long one may be used up
            options["time_limit"] = self.random.choice([0.05, 0.01, 1e-9, 0, -1, float("nan"), "0.05", "x"])
        return options

    def path(self):
        return self.random.choice([self.directory / "p.json", self.directory, "", "/nowhere/p", "\0", "\udc80", None])

    def spoil(self, arguments):
        """Sometimes one argument is something else."""
        if arguments and self.chance(0.15):
            arguments = list(arguments)
            arguments[self.random.randrange(len(arguments))] = self.anything()
        return arguments


class MotionMaker(Maker):
    """Makes arguments of calls that plan motions of the robot of URDF3, and keeps the motions."""

    def __init__(self, seed, directory, planner):
        super().__init__(seed, directory, hostile=0.02)
        self.planner = planner
        self.motions = []

    def goal(self):
        kind = self.random.randrange(8)
        if kind == 0:
            return super().goal()
        if kind == 1:
            return {self.name("a", "b", "c"): self.number()}
        if kind == 2:
            return [self.reached(), self.numbers(3)]
        if kind == 3:
            tolerances = (self.random.choice([0.01, 0.1, float("inf"), self.number()]) for _ in range(2))
            return srmp.GoalConstraint(srmp.GoalType.POSE, self.reached(), *tolerances)
        return self.reached() if kind == 4 else self.numbers(3)

    def reached(self):
        """A pose of the end effector at some configuration; sometimes any pose."""
        if self.chance(0.1):
            return self.pose()
        return self.planner.compute_fk("arm", [round(self.random.uniform(-3, 3), 3) for _ in range(3)], "lower")

    def near(self, q):
        """Poses of the end effector on a motion of the joints that begins at q."""
        try:
            steps = np.cumsum(np.array([self.numbers(3) for _ in range(self.random.randrange(1, 4))]) / 10, axis=0)
            return [self.planner.compute_fk("arm", np.asarray(q) + step, "lower") for step in steps]
        except (srmp.Error, TypeError, ValueError):
            return [self.reached()]

    def motion(self):
        """One that was planned, or one of hostile numbers, which may be refused."""
        if self.motions and self.chance(0.9):
            return self.random.choice(self.motions)
        rows = [self.numbers(3) for _ in range(self.random.choice([0, 1, 2, 3, 3, 4]))]
        times = np.cumsum([3 + abs(self.number()) for _ in rows])
        times = times - times[0] if rows and self.chance(0.9) else times
        velocities = np.zeros((len(rows), 3)) if self.chance(0.8) else [self.numbers(3) for _ in rows]
        return srmp.Trajectory(["a", "b", "c"], rows, times, velocities)

    def instant(self, motion):
        return round(self.random.random() * motion.duration, 3) if self.chance(0.9) else self.number()

    def constraint(self):
        c, link = (
            srmp.PathConstraint,
            {"link": self.name("", "", "lower", "middle"), "frame": self.name("", "", "upper", "box")},
        )
        lengths = self.random.choice([self.length(), [self.length() for _ in range(3)], float("inf")])
        return self.random.choice(
            [
                lambda: c.cone(self.numbers(3), self.numbers(3), self.length(), **link),
                lambda: c.orientation(self.numbers(4), lengths, **link),
                lambda: c.pose(self.reached(), lengths, self.length(), **link),
                lambda: c.box(
                    [3 * self.length() for _ in range(3)], self.pose(), **link, point_in_link=self.numbers(3)
                ),
                lambda: c.plane([0, 0, 0], [0, 0, 1], self.length(), **link),
                lambda: c.plane(self.numbers(3), self.numbers(3), self.length(), **link),
                lambda: c.line(self.numbers(3), self.numbers(3), self.length(), **link),
                lambda: c.distance(self.numbers(3), 0.0, 2 * self.length(), **link),
            ]
        )()

    def constraints(self):
        if self.chance(0.7):
            return []
        return [self.constraint() for _ in range(self.random.randrange(1, 3))] if self.chance(0.95) else self.anything()

    def segment(self):
        s = srmp.Segment
        return self.random.choice(
            [
                lambda: s.move(
                    self.goal(), constraints=self.constraints(), blend_radius=self.chance(0.3) * self.length()
                ),
                lambda: s.move(self.numbers(3), blend_radius=self.chance(0.5) * self.length()),
                lambda: s.linear(self.reached(), constraints=self.constraints()),
                lambda: s.linear(offset=[x / 20 for x in self.numbers(3)]),
                lambda: s.follow([self.reached()], max_deviation=self.length() / 10, constraints=self.constraints()),
                lambda: s.attach(self.name("box", "ball"), self.name("lower", "middle"), touch_links=["finger"]),
                lambda: s.detach(self.name("box", "ball")),
                lambda: s.allow(
                    self.name("box", "ball"), self.name("lower", "box", "finger"), allowed=self.chance(0.7)
                ),
                lambda: s.joints({self.name("f", "f", "a"): self.length() / 10}, duration=self.length()),
                lambda: s.wait(self.length()),
            ]
        )()

    def request(self):
        options = {"options": self.options()} if self.chance(0.3) else {}
        return srmp.PlanRequest(
            "arm", self.numbers(3), self.goal_of_request(), constraints=self.constraints(), **options
        )

    def goal_of_request(self):
        return self.reached() if self.chance(0.3) else self.numbers(3)


def changed(random, text: bytes) -> bytes:
    """The text with a few changes of bytes, words and lines."""
    for _ in range(random.randrange(1, 16 if random.random() < 0.2 else 4)):
        kind, at = random.randrange(6), random.randrange(len(text) or 1)
        if kind == 0:
            text = text[:at] + bytes([random.randrange(256)]) + text[at + 1 :]
        elif kind == 1:
            text = text[:at] + text[at + random.randrange(1, 64) :]
        elif kind == 2:
            lines = text.splitlines(keepends=True) or [b""]
            line = random.randrange(len(lines))
            lines[line : line + 1] = [lines[line]] * random.choice([0, 2])
            text = b"".join(lines)
        else:  # a word: another of the text, or a hostile one
            words = text.split(b" ")
            words[random.randrange(len(words))] = random.choice(words if kind == 3 else HOSTILE)
            text = b" ".join(words)
    return text
