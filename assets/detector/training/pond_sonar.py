"""What a sounder hears and shows of a varied pond (`pond_scenes.py`)."""

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage, special

from pond_bed import Bed

LENGTH_M = 33.4
ROSE = 5.0  # signal-to-noise ratio of the rectangle that shows an object best, from which it is asked for
FAINT_DB, CORE_DB, WINDOW_M = 1.0, 2.0, (0.45, 0.21)


@dataclass
class Recorder:
    """One sounder and how it is sailed."""

    range_m: float
    samples: int
    ping_m: float
    exponent: float
    dull: float
    facets: float
    facets_rad: float
    tilt_deg: float
    lobe_deg: float
    beam_rad: float
    pulse_m: float
    trail_m: float
    looks: float
    grain: int
    floor: float
    spreading: float
    law: str
    power: float
    span_db: float
    top: float
    art: bool

    @staticmethod
    def draw(rng) -> "Recorder":
        """Half of them close to what `pond.py` is, the others anything that an owner of a small boat might have."""
        near = rng.random() < 0.5
        range_m = rng.uniform(8, 16) if near else rng.uniform(8, 25)
        looks = 1.0 if rng.random() < 0.6 else rng.uniform(0.8, 4)
        law = str(rng.choice(["decibels", "power"], p=[0.7, 0.3] if near else [0.45, 0.55]))
        return Recorder(
            range_m=range_m,
            samples=int(rng.choice([1400, 1400, 1000, 700])),
            ping_m=10 ** (rng.uniform(-1.0, -0.55) if near else rng.uniform(-1.35, -0.5)),
            exponent=rng.uniform(1.2, 2.4) if near else rng.uniform(0.7, 2.6),
            dull=10 ** rng.uniform(-3.0, -2.4),
            facets=10 ** rng.uniform(-1.8, -0.8),
            facets_rad=math.radians(rng.uniform(4, 12)),
            tilt_deg=rng.uniform(38, 55),
            lobe_deg=rng.uniform(24, 38),
            beam_rad=0.0 if rng.random() < 0.5 else math.radians(rng.uniform(0.4, 1.6)),
            pulse_m=rng.uniform(0.006, 0.025) if near else 10 ** rng.uniform(-2.3, -1.2),
            trail_m=0.0 if near or rng.random() < 0.5 else 10 ** rng.uniform(-1.7, -0.9),
            looks=looks,
            grain=1 if near else int(rng.integers(1, 6)),
            floor=10 ** rng.uniform(-0.7, 0.9),
            spreading=rng.uniform(2.6, 3.3),
            law=law,
            power=float(rng.choice([0.5, 0.35, 0.25, 0.125])),
            span_db=rng.uniform(22, 42),
            top=rng.uniform(100, 250),
            art=rng.random() < 0.7,
        )


class Pass:
    """One stretch sailed over one bed: what each side would show on average, and one draw of it."""

    def __init__(self, rng):
        self.rng, self.recorder = rng, Recorder.draw(rng)
        one = self.recorder
        count = int(LENGTH_M / one.ping_m) + 2
        turn = rng.uniform(-0.01, 0.01) if rng.random() < 0.8 else rng.choice([-1, 1]) * rng.uniform(0.08, 0.17)
        sailed_m = one.ping_m * np.arange(count)
        self.heading = rng.uniform(0, 6.28) + turn * sailed_m + 0.03 * np.sin(sailed_m * rng.uniform(0.1, 0.6))
        self.east = np.cumsum(np.sin(self.heading)) * one.ping_m
        self.north = np.cumsum(np.cos(self.heading)) * one.ping_m
        self.per_sample_m = one.range_m / one.samples
        self.step_m = 0.7 * self.per_sample_m
        self.across = np.arange(self.step_m / 2, one.range_m, self.step_m, dtype=np.float32)
        self.slant = (np.arange(one.samples) + 0.5) * self.per_sample_m
        self.bed = Bed(rng, one.range_m)
        self.attenuation = rng.uniform(0.05, 0.2)
        self.gain = np.maximum(self.slant, 0.2) ** one.spreading * 10 ** (2 * self.attenuation * self.slant / 10)
        self.noise = one.floor * ((3 if one.art else 1) * 6e-11 * np.maximum(self.slant, 0.2) ** -2 + 4e-11)
        self.ringing = 2e-2 * np.exp(-self.slant / 0.035) + 4e-6 * np.exp(-self.slant / 0.12)
        self.drop = np.ones(count)
        if one.art and rng.random() < 0.15:
            start = rng.integers(0, count)
            self.drop[start : start + int(rng.uniform(3, 12) / one.ping_m)] = rng.uniform(0.1, 0.5)
        trail = max(one.trail_m, 1e-4)
        reach = np.arange(-4 * one.pulse_m, 4 * one.pulse_m + 4 * one.trail_m + self.per_sample_m, self.per_sample_m)
        shape = np.exp(-0.5 * (reach / one.pulse_m) ** 2)
        if one.trail_m:
            shape = np.convolve(shape, np.exp(-np.arange(0, 4 * trail, self.per_sample_m) / trail))
        self.pulse, self.centre = shape / shape.sum(), int(4 * one.pulse_m / self.per_sample_m)

    def place(self, thing, sign: int) -> tuple[np.ndarray, np.ndarray]:
        """Where an object is from each ping: outward on a side, and ahead, metres."""
        east, north = thing.east - self.east, thing.north - self.north
        outward = (east * np.cos(self.heading) - north * np.sin(self.heading)) * sign
        return outward, east * np.sin(self.heading) + north * np.cos(self.heading)

    def heard(self, sign: int, pings: slice, things: list) -> np.ndarray:
        """Mean intensity `[pings, samples]` of one side without noise, gain not yet."""
        one, y = self.recorder, self.across[None]
        heading = self.heading[pings, None]
        east = (self.east[pings, None] + sign * np.cos(heading) * y).astype(np.float32)
        north = (self.north[pings, None] - sign * np.sin(heading) * y).astype(np.float32)
        depth, strength = self.bed.shape(east, north)
        for thing in things:
            outward, ahead = self.place(thing, sign)
            outward, ahead = outward[pings], ahead[pings]
            beside = np.abs(ahead) < thing.reach + 0.1 + self.across[-1] * np.abs(np.gradient(self.heading)).max() * 4
            rows = np.flatnonzero(beside & (np.abs(outward) < self.across[-1] + thing.reach))
            if not len(rows):
                continue
            rows = slice(rows[0], rows[-1] + 1)
            low, high = np.searchsorted(self.across, (outward[rows].min() - thing.reach, outward[rows].max() + thing.reach))
            part = (rows, slice(low, high))
            top = thing.top(east[part], north[part])
            depth[part] -= top
            strength[part] = np.where(top > 0, strength[part] * thing.strength, strength[part])
        slope = np.gradient(depth, self.step_m, axis=1)
        slant, angle = np.hypot(y, depth), np.arctan2(y, depth)
        lit = angle >= np.concatenate([np.full((len(angle), 1), -1, np.float32), np.maximum.accumulate(angle, 1)[:, :-1]], 1)
        facing = np.clip((depth - y * slope) / (slant * np.sqrt(1 + slope**2)), 1e-6, 1)
        tangent = (1 - facing**2) / facing**2
        law = one.dull * facing**one.exponent + one.facets * np.exp(-tangent / (2 * one.facets_rad**2))
        beam = np.exp(-2 * math.log(2) * ((np.degrees(angle) - one.tilt_deg) / one.lobe_deg) ** 2)
        spread = slant * 0.0157 * self.step_m / np.maximum(slant, 0.2) ** 4 * 10 ** (-0.2 * self.attenuation * slant)
        power = law * strength * beam * lit * spread
        at = (slant / self.per_sample_m).astype(np.int64)
        inside = at < one.samples
        flat = (np.arange(len(at))[:, None] * one.samples + at)[inside]
        sums = np.bincount(flat, power[inside], len(at) * one.samples).reshape(len(at), one.samples)
        if one.beam_rad:
            spread = 0.5 * one.range_m * one.beam_rad / 2.35 / one.ping_m
            sums = ndimage.gaussian_filter1d(sums, spread, axis=0, mode="nearest", truncate=3)
        return ndimage.convolve1d(sums, self.pulse, axis=1, mode="constant", origin=self.centre - len(self.pulse) // 2)

    def decibels(self, mean: np.ndarray, pings: slice) -> np.ndarray:
        """Mean displayed level, noise and limits of the display included."""
        total = (mean + self.noise + self.ringing) * self.drop[pings, None] * self.gain
        return np.clip(10 * np.log10(np.maximum(total, 1e-16)), self.lowest_db, self.top_db + 1)

    def drawn(self, mean: np.ndarray, sign: int) -> np.ndarray:
        """One draw of the intensity after gain: speckle, noise, fish, weed in the water, interference."""
        one, rng = self.recorder, self.rng
        grains = (len(mean), -(-one.samples // one.grain))
        speckle = rng.gamma(one.looks, 1 / one.looks, grains).repeat(one.grain, 1)[:, : one.samples]
        out = mean * speckle + self.noise * rng.exponential(1, mean.shape) + self.ringing * rng.gamma(4, 0.25, mean.shape)
        below = self.bed.shape(self.east[:, None].astype(np.float32), self.north[:, None].astype(np.float32))[0][:, 0]
        if one.art:
            for ping in np.flatnonzero(rng.random(len(mean)) < 0.03):
                at = rng.uniform(0.5, max(0.6, 0.92 * below[ping]))
                near = np.abs(self.slant - at) < 0.04
                out[ping, near] += 9e-5 * rng.exponential(1, near.sum()) * at**-3
            for ping in np.flatnonzero(rng.random(len(mean)) < 0.015):
                out[ping] += rng.exponential(2e-6, one.samples) * (rng.random(one.samples) < 0.08)
            if rng.random() < 0.2:
                start = rng.integers(0, len(mean))
                for ping in range(start, min(start + int(rng.uniform(2, 10) / one.ping_m), len(mean))):
                    height = 0.25 + 0.2 * abs(math.sin(ping * 0.12))
                    grown = (self.slant > below[ping] - height) & (self.slant < below[ping])
                    out[ping, grown] += 10**-5.8 * np.maximum(self.slant[grown], 0.2) ** -3 * rng.gamma(0.7, 1, grown.sum())
        return out * self.drop[:, None] * self.gain

    def scale(self, intensity: np.ndarray) -> None:
        """Settles white and black of the recorder by what it hears."""
        level = 10 * np.log10(np.maximum(intensity, 1e-16))
        self.top_db = float(np.percentile(level[:, int(0.18 * self.recorder.samples) :], 99.5))
        span = self.recorder.span_db if self.recorder.law == "decibels" else 20 / self.recorder.power
        self.lowest_db = self.top_db - min(span, 80)

    def levels(self, intensity: np.ndarray) -> np.ndarray:
        """The recorder's bytes."""
        one, over = self.recorder, 10 * np.log10(np.maximum(intensity, 1e-16)) - self.top_db
        share = 1 + over / one.span_db if one.law == "decibels" else 10 ** (over / 10 * one.power)
        return np.round(np.clip(share * one.top, 0, min(255, one.top * 1.04)))

    def shown(self, thing, others: list, sign: int, mean: np.ndarray) -> tuple[float, np.ndarray] | None:
        """Signal-to-noise ratio of an object on a side, and its box: pings from and to, metres from and to."""
        one = self.recorder
        outward, ahead = self.place(thing, sign)
        near = np.flatnonzero((outward > -thing.reach) & (np.abs(ahead) < thing.reach + 0.6 + outward.clip(0) * one.beam_rad))
        if len(near) < 2:
            return None
        pings = slice(near[0], near[-1] + 1)
        apart = self.decibels(mean[pings], pings) - self.decibels(self.heard(sign, pings, others), pings)
        spread = 10 / math.log(10) * math.sqrt(float(special.polygamma(1, one.looks)))
        best = 0.0
        for along in (0.5, 0.9, 1.6, 2.7):
            for out in (0.08, 0.21, 0.52, 1.0, 1.7):
                size = (min(max(1, round(along / one.ping_m)), len(apart)), max(1, round(out / self.per_sample_m)))
                seen = np.abs(ndimage.uniform_filter(apart, size, mode="constant")).max()
                # Means of pings that a wide beam joins hold less than as many on their own.
                best = max(best, seen * math.sqrt(size[0] * size[1] / one.grain) / spread)
        window = [max(1, round(length / step)) for length, step in zip(WINDOW_M, (one.ping_m, self.per_sample_m))]
        fine, boxes = np.abs(ndimage.uniform_filter(apart, window, mode="constant")), []
        for limit in (FAINT_DB, CORE_DB):
            rows = np.flatnonzero((fine >= limit).sum(1) >= 0.04 / self.per_sample_m)
            if len(rows):
                columns = np.flatnonzero((fine >= limit).any(0))
                along = [pings.start + rows[0], pings.start + rows[-1] + 1]
                boxes.append([*along, columns[0] * self.per_sample_m, (columns[-1] + 1) * self.per_sample_m])
        if not boxes:
            return None
        aside = np.median(outward[pings]) <= 0 or best < ROSE
        return (min(best, ROSE - 0.1) if aside else best), np.mean(boxes, 0)
