"""Fields of boulders laid over pictures, as dense as tufts of weed: each that shows is an object.

Weed taught as no object (`weed.py`) also teaches that what stands close together is none, and a bed of boulders then goes unfound.
A boulder is a rough half ellipsoid of 0.25 to 1.8 m that sound does not pass: its face is bright, what lies behind it is dark to the
end of its shadow, which `Weed.shade` draws with the same geometry. Boxes hold echo and shadow, as those of the simulated chips.
"""

import torch
import torch.nn.functional as F

from data import ABSENT, IGNORE
from weed import CLEAR_PX, DARKEST, PIXEL_M, Weed

MOST = 20
ROCK = "rock"
# Below this share of its face in sight, or of this size, it may be found or not.
SHOWN, SMALLEST_M = 0.6, 0.3


class Boulders(Weed):
    """Draws fields of boulders over pictures, from one generator; `kind` is their class."""

    def __init__(self, generator: torch.Generator, device, kind: int):
        super().__init__(generator, device)
        self.kind = kind

    def numbers(self, count: int, low: float, high: float) -> torch.Tensor:
        """A seeded number for each boulder, `[count, MOST]`."""
        return torch.rand(count, MOST, generator=self.generator, device=self.device) * (high - low) + low

    def strewn(self, x: torch.Tensor, boxes: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Pictures `[count, 1, side, side]` with boulders in free places, and the boxes with theirs behind them."""
        count, side = len(x), x.shape[-1]
        # Fields lie together: around a place of each picture, over a third of it or all of it.
        spread = self.numbers(count, 0.3, 1.2)[:, :1]
        column = (self.numbers(count, 0.1, 0.9)[:, :1] + spread * self.numbers(count, -0.5, 0.5)) * side
        row = (self.numbers(count, 0.1, 0.9)[:, :1] + spread * self.numbers(count, -0.5, 0.5)) * side
        mean_m = torch.exp(self.numbers(count, -2.0, -0.6)[:, :1])
        across = mean_m * torch.exp(self.numbers(count, -0.6, 0.6)) / PIXEL_M
        along = across * torch.exp(self.numbers(count, -0.4, 0.5))
        height_m = across * PIXEL_M * self.numbers(count, 0.6, 1.5)
        there = self.numbers(count, 0, 1) < self.numbers(count, 0.15, 1.0)[:, :1]
        there &= free(boxes, column, row, across, along, side) & seabed(x, column, row)
        relief = self.relief(there, column, row, across, along, height_m, side)
        dark = self.shade(relief)
        facing = F.pad(relief.diff(dim=-1), (1, 0)).clamp(min=0) / PIXEL_M
        echo = 1 + self.uniform(count, 0.3, 2.2) * facing.clamp(max=1.2) + self.uniform(count, 0.0, 0.4) * (relief > 0)
        drawn = x * echo * (1 - dark) + dark * DARKEST * x.mean((2, 3), keepdim=True)
        return drawn, torch.cat([boxes, self.boxes(there, column, row, across, along, dark)], 1)

    def relief(self, there, column, row, across, along, height_m, side: int) -> torch.Tensor:
        """Height of the boulders above the bottom in metres, `[count, 1, side, side]`: rough half ellipsoids."""
        count, at = len(there), torch.arange(side, device=self.device) + 0.5
        rough = 1 + 0.25 * self.field(count, side, self.spacing(3, 6)) * self.uniform(count, 0.0, 1.0)
        bluntness = self.uniform(count, 1.5, 4.0)[..., 0]
        relief = torch.zeros(count, side, side, device=self.device)
        for one in range(MOST):
            here = there[:, one, None, None]
            u = ((at[None, None, :] - column[:, one, None, None]) / across[:, one, None, None]).abs() ** bluntness
            v = ((at[None, :, None] - row[:, one, None, None]) / along[:, one, None, None]).abs() ** bluntness
            dome = height_m[:, one, None, None] * (1 - u - v).clamp(min=0).sqrt()
            relief = torch.maximum(relief, dome * here)
        return relief.unsqueeze(1) * rough.clamp(min=0.3)

    def boxes(self, there, column, row, across, along, dark) -> torch.Tensor:
        """Class, x1, y1, x2, y2 of each boulder: its outline and its shadow as far as its middle rows are dark."""
        side = dark.shape[-1]
        at = torch.arange(side, device=self.device)
        shades = [shade_at(dark, row + step * along) for step in (-0.35, 0.0, 0.35)]
        beyond = at >= (column + across)[..., None]
        end = torch.stack([torch.where(beyond & (shade < 0.5), at, side).amin(-1) for shade in shades]).amax(0)
        shade = shades[1]
        # The nearer half of its middle row, as far as it lies in the picture, is in sight or in another's shadow.
        face = (at > (column - 0.8 * across)[..., None]) & (at < (column - 0.1 * across)[..., None])
        shown = ((1 - shade) * face).sum(-1) / face.sum(-1).clamp(min=1)
        x1, x2 = (column - across).clamp(0, side), torch.maximum(column + across, end).clamp(0, side)
        y1, y2 = (row - along).clamp(0, side), (row + along).clamp(0, side)
        inside = (column > 0) & (column < side - 2 * CLEAR_PX) & (row > 0) & (row < side)
        plain = inside & (shown > SHOWN) & (2 * across * PIXEL_M > SMALLEST_M)
        kind = torch.where(plain, float(self.kind), float(IGNORE))
        gone = ~there | (x2 - x1 < 2) | (y2 - y1 < 2)
        return torch.stack([torch.where(gone, float(ABSENT), kind), x1, y1, x2, y2], -1)


def free(boxes: torch.Tensor, column, row, across, along, side: int) -> torch.Tensor:
    """Which boulders lie, with a shadow of three times their width, clear of every box."""
    kind, x1, y1, x2, y2 = (part[:, None] for part in boxes.unbind(-1))
    beside = (column + 7 * across)[..., None] < x1 - CLEAR_PX
    beside |= (column - across)[..., None] > x2 + CLEAR_PX
    beside |= (row + along)[..., None] < y1 - CLEAR_PX
    beside |= (row - along)[..., None] > y2 + CLEAR_PX
    return (beside | (kind == ABSENT)).all(-1)


def seabed(x: torch.Tensor, column, row) -> torch.Tensor:
    """Which places show echoes of the bottom: neither water, nor margin, nor deep shadow."""
    side = x.shape[-1]
    local = F.avg_pool2d(x, 17, 1, 8)[:, 0]
    at = row.round().long().clamp(0, side - 1) * side + column.round().long().clamp(0, side - 1)
    return local.flatten(1).gather(1, at) > 0.5 * x.mean((2, 3))


def shade_at(dark: torch.Tensor, row: torch.Tensor) -> torch.Tensor:
    """The line of pixels of each picture `[count, 1, side, side]` at each row `[count, some]`: `[count, some, side]`."""
    side = dark.shape[-1]
    return dark[:, 0].gather(1, row.round().long().clamp(0, side - 1)[..., None].expand(-1, -1, side))
