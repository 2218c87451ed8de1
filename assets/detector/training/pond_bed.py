"""The bed of a varied pond and the objects on it (`pond_scenes.py`)."""

import math
from dataclasses import dataclass

import numpy as np

# Least and largest length, width and height of each kind.
SIZES_M = {
    "rock": ((0.6, 0.6, 0.3), (2.0, 1.4, 0.8)),
    "block": ((0.6, 0.5, 0.3), (2.0, 1.2, 0.8)),
    "bar": ((2.0, 0.25, 0.25), (4.0, 0.5, 0.5)),
}


@dataclass
class Thing:
    """A rock (half an ellipsoid), a block or a bar (boxes)."""

    kind: str
    east: float
    north: float
    turned: float
    length: float
    width: float
    height: float
    strength: float

    @property
    def reach(self) -> float:
        """Radius around its middle that holds it, metres."""
        return math.hypot(self.length, self.width) / 2

    def top(self, east, north) -> np.ndarray:
        """Its height over the bed, metres; 0 beside it."""
        east, north = east - self.east, north - self.north
        along = (east * math.cos(self.turned) + north * math.sin(self.turned)) / (self.length / 2)
        beside = (north * math.cos(self.turned) - east * math.sin(self.turned)) / (self.width / 2)
        if self.kind == "rock":
            return self.height * np.sqrt(np.clip(1 - along**2 - beside**2, 0, 1))
        return self.height * ((np.abs(along) < 1) & (np.abs(beside) < 1))

    @staticmethod
    def draw(rng, east: float, north: float) -> "Thing":
        """Sizes of `pond.py`, and around them."""
        kind = str(rng.choice(list(SIZES_M)))
        low, high = SIZES_M[kind]
        factor = 1.0 if rng.random() < 0.5 else math.exp(rng.uniform(-0.5, 0.3))
        size = rng.uniform(low, high) * factor
        strength = 1.0 if rng.random() < 0.6 else 10 ** rng.uniform(-0.3, 0.5)
        return Thing(kind, east, north, float(rng.uniform(0, 3.1)), *map(float, size), strength)


class Bed:
    """Swells, waves, mounds and patches; drawn anew for each scene."""

    def __init__(self, rng, range_m: float):
        self.phase = rng.uniform(0, 6.28, 10)
        self.mean = float(np.clip(range_m * rng.uniform(0.1, 0.32), 1.2, 7))
        self.swell = rng.uniform(0.3, 1.2) * min(0.27 * self.mean, 0.9)
        self.waves = rng.uniform(0.0, 0.08)
        self.patches = rng.uniform(0.1, 0.8) if rng.random() < 0.5 else 0.0
        count = rng.integers(2, 12) if rng.random() < 0.35 else 0
        self.mounds = [
            (
                *rng.uniform(-range_m, range_m + 15, 2),
                rng.choice([-1, 1]) * min(rng.uniform(0.2, 0.7), 0.4 * self.mean),
                rng.uniform(1.0, 2.6),
            )
            for _ in range(count)
        ]
        self.patch = [(rng.uniform(0.3, 2.5), rng.uniform(0.3, 2.5)) for _ in range(4)]

    def shape(self, east, north) -> tuple[np.ndarray, np.ndarray]:
        """Depth (m) and strength of the echo at some places."""
        p = self.phase
        depth = self.mean + self.swell * (np.sin(east / 23 + p[0]) * np.cos(north / 29 + p[1]) + 0.5 * np.sin(north / 13 + p[2]))
        depth += self.waves * np.sin(east * 1.3 + p[3]) * np.sin(north * 1.1 + p[4])
        for middle_e, middle_n, height, wide in self.mounds:
            depth -= height * np.exp(-((east - middle_e) ** 2 + (north - middle_n) ** 2) / (2 * wide * wide))
        strength = np.ones_like(depth)
        if self.patches:
            rough = 0
            for i, (a, b) in enumerate(self.patch):
                rough = rough + np.sin(east * a + p[5 + i] + np.sin(north * b)) * np.sin(north * a + p[6 + i])
            strength = np.exp(self.patches * np.tanh(2 * rough)).astype(np.float32)
        return np.maximum(depth, 0.7), strength

    def strew(self, boat, rng) -> list[Thing]:
        """Objects on both sides of a boat's stretch, none nearer than 4 m to another; none at all in one scene of four."""
        if rng.random() < 0.25:
            return []
        range_m, things = boat.recorder.range_m, []
        for _ in range(int(rng.uniform(0.3, 1.0) * range_m)):
            ping = int(rng.integers(0, len(boat.heading)))
            out = rng.choice([-1, 1]) * math.sqrt(max(rng.uniform(0.15, 1), 0.15)) * range_m
            east = boat.east[ping] + out * math.cos(boat.heading[ping])
            north = boat.north[ping] - out * math.sin(boat.heading[ping])
            if all(math.hypot(east - one.east, north - one.north) > 4 for one in things):
                things.append(Thing.draw(rng, float(east), float(north)))
        return things
