"""Beds of water weed laid over pictures: ragged echoes with shadows, many beside each other, that are no objects.

A bed is a patch of plants 0.05 to 0.6 m high whose sound-proofness varies: what lies behind a plant, seen from the transducer, is
darker by that. The shadow is the geometry of side-scan sonar (a point is in the shade where something nearer stands above the line
from it to the transducer); outlines, sizes and strengths are free draws, made to vary widely and not to look like one lake.
"""

import torch
import torch.nn.functional as F

from data import ABSENT

# Rows and columns around an object, and columns before it, where nothing grows: its echo and shadow stay as they are.
CLEAR_PX, BEFORE_PX = 6.0, 60.0
PIXEL_M = 0.04
# What a shadow is left with, as a share of the picture's mean.
DARKEST = 0.12


class Weed:
    """Draws beds over pictures, from one generator."""

    def __init__(self, generator: torch.Generator, device):
        self.generator, self.device = generator, device

    def uniform(self, count: int, low: float, high: float) -> torch.Tensor:
        """A seeded number for each picture, `[count, 1, 1, 1]`."""
        return torch.rand(count, 1, 1, 1, generator=self.generator, device=self.device) * (high - low) + low

    def field(self, count: int, side: int, spacing: int) -> torch.Tensor:
        """Smooth noise of deviation near 1 that changes over `spacing` pixels, `[count, 1, side, side]`."""
        few = side // spacing + 3
        grains = torch.randn(count, 1, few, few, generator=self.generator, device=self.device)
        wide = F.interpolate(grains, size=(few * spacing, few * spacing), mode="bicubic", align_corners=False)
        return 1.3 * wide[..., spacing : spacing + side, spacing : spacing + side]

    def spacing(self, low: int, high: int) -> int:
        """A seeded whole number, one for a whole batch."""
        return int(torch.randint(low, high + 1, (1,), generator=self.generator, device=self.device))

    def beds(self, count: int, side: int) -> torch.Tensor:
        """How densely each place is grown, 0 to 1: patches of one to four metres, with hard or soft rims."""
        broad = self.field(count, side, self.spacing(18, 60)) + 0.4 * self.field(count, side, self.spacing(6, 14))
        return ((broad - self.uniform(count, 0.1, 1.7)) * self.uniform(count, 0.8, 5.0)).clamp(0, 1)

    def leaves(self, count: int, side: int) -> torch.Tensor:
        """What stands up within a bed, 0 to some 2: tufts of a few centimetres to decimetres, drawn out along the track by the beam."""
        fine, coarse = self.field(count, side, self.spacing(2, 4)), self.field(count, side, self.spacing(5, 10))
        share = self.uniform(count, 0.0, 1.0)
        tufts = (fine * share + coarse * (1 - share) - self.uniform(count, -0.6, 0.5)).clamp(min=0)
        drawn = F.avg_pool2d(F.pad(tufts, (0, 0, 4, 4), mode="replicate"), (9, 1), 1)
        return torch.where(self.uniform(count, 0, 1) < 0.4, drawn, tufts)

    def grown(self, x: torch.Tensor, boxes: torch.Tensor) -> torch.Tensor:
        """Pictures `[count, 1, side, side]` with beds over them, but for the places of their boxes."""
        count, side = len(x), x.shape[-1]
        bed = self.beds(count, side) * clear(boxes, side)
        leaves = bed * self.leaves(count, side)
        height_m = leaves * torch.exp(self.uniform(count, -3.0, -0.7))
        dark = self.shade(height_m)
        facing = F.pad(height_m.diff(dim=-1), (1, 0)).clamp(min=0) / PIXEL_M
        strength = 1 + self.uniform(count, 0.0, 1.5) * leaves + self.uniform(count, 0.0, 2.0) * facing.clamp(max=1.5)
        dark = dark * self.uniform(count, 0.15, 0.85)
        return x * strength * (1 - dark) + dark * DARKEST * x.mean((2, 3), keepdim=True)

    def shade(self, height_m: torch.Tensor) -> torch.Tensor:
        """Share 0 to 1 of each place's echo that what stands nearer takes away, seen from 1.2 to 7 m above the bottom."""
        count, side = len(height_m), height_m.shape[-1]
        altitude_m, nearest_m = torch.exp(self.uniform(count, 0.2, 1.95)), torch.exp(self.uniform(count, -0.5, 2.7))
        away_m = nearest_m + torch.arange(side, device=self.device) * PIXEL_M
        upward = (height_m - altitude_m) / away_m
        below_m = (upward.cummax(-1).values - upward) * away_m
        return (below_m / 0.04).clamp(0, 1)


def clear(boxes: torch.Tensor, side: int) -> torch.Tensor:
    """1 where weed may grow, 0 at and just before each box, `[count, 1, side, side]`."""
    at = torch.arange(side, device=boxes.device) + 0.5
    kind, x1, y1, x2, y2 = boxes.unbind(-1)
    columns = (at > (x1 - BEFORE_PX)[..., None]) & (at < (x2 + CLEAR_PX)[..., None])
    rows = (at > (y1 - CLEAR_PX)[..., None]) & (at < (y2 + CLEAR_PX)[..., None])
    held = rows[..., :, None] & columns[..., None, :] & (kind != ABSENT)[..., None, None]
    return 1 - held.any(1, keepdim=True).float()
