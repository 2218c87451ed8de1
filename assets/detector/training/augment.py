"""Varies a batch of chips on the device that trains: geometry first, then what sonars and gains do to a picture.

Rows may be mirrored (the boat may come from either end); columns never: range grows outward and shadows fall outward.
"""

from dataclasses import dataclass, replace

import torch
import torch.nn.functional as F

from boulders import Boulders
from dashes import Dashes
from data import ABSENT, IGNORE, Chips
from weed import Weed

# Below this visible share a cut object is no longer a truth, and below the second nothing at all.
TRUTH_SHARE, TRACE_SHARE = 0.45, 0.08
SMALLEST_PX = 3.0


@dataclass
class Strength:
    """How far to vary. Shares are probabilities per chip; `calm()` is used for the last stretch of a training."""

    mosaic: float = 0.3
    scale: float = 1.25
    stretch: float = 1.1
    shift: float = 0.1
    gamma: float = 0.35
    gain: float = 0.25
    ramp: float = 0.5
    speckle: float = 0.2
    row_gain: float = 0.12
    blur: float = 0.15
    dropouts: float = 0.2
    # Shares of pictures with the marks of other recorders than the simulated ones.
    smear: float = 0.0
    along: float = 0.0
    floor: float = 0.0
    law: float = 0.0
    curve: float = 0.0
    grains: float = 0.0
    # Shares of pictures with beds of weed, with fields of boulders, and with the shadows of fish.
    weed: float = 0.0
    boulders: float = 0.0
    dashes: float = 0.0

    def calm(self) -> "Strength":
        """Nearly the data as it is: no mosaic, little change of scale and light, other recorders half as often."""
        others = (share / 2 for share in (self.smear, self.along, self.floor, self.law, self.curve, self.grains))
        scale = 1 + (self.scale - 1) / 4
        return Strength(0.0, scale, 1.03, 0.05, 0.12, 0.1, 0.15, 0.06, 0.04, 0.05, 0.1, *others, self.weed, self.boulders, self.dashes)

    def of_other_recorders(self) -> "Strength":
        """The same, and the marks of other recorders: `--recorders`."""
        return replace(self, scale=1.45, smear=0.45, along=0.25, floor=0.25, law=0.3, curve=0.3, grains=0.35)


class Augmenter:
    """Draws varied batches from chips that lie on a device.

    `side` is that of the pictures: smaller than the chips' for cut-outs at the same scale, each at random or, for the share
    `focus` of the chips with objects, around one of these. `rock` is the class of boulders.
    """

    def __init__(self, chips: Chips, strength: Strength, generator: torch.Generator, side: int | None = None, focus: float = 0.0, rock: int = 0):
        self.chips, self.strength, self.generator = chips, strength, generator
        self.side, self.focus = side or chips.side, focus
        self.rock, self.device = rock, chips.images.device

    def uniform(self, *shape: int, low: float = 0.0, high: float = 1.0) -> torch.Tensor:
        """Seeded uniform numbers on the device."""
        return torch.rand(*shape, generator=self.generator, device=self.device) * (high - low) + low

    def log_uniform(self, *shape: int, factor: float) -> torch.Tensor:
        """Seeded factors between 1/factor and factor, symmetric in the logarithm."""
        return factor ** self.uniform(*shape, low=-1.0, high=1.0)

    def batch(self, index: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Varied pictures `[batch, 1, side, side]` in 0..1 and their boxes `[batch, slots, 5]`."""
        images, boxes = self.compose(index)
        if self.strength.boulders:
            rocks = Boulders(self.generator, self.device, self.rock)
            strewn, more = rocks.strewn(images, boxes)
            chosen = self.chance(self.strength.boulders, len(images))
            images = torch.where(chosen, strewn, images)
            more[..., 0] = torch.where(chosen[:, :, 0, 0], more[..., 0], ABSENT)
            boxes = torch.cat([boxes, more[:, boxes.shape[1] :]], 1)
        if self.strength.weed:
            overgrown = Weed(self.generator, self.device).grown(images, boxes)
            images = torch.where(self.chance(self.strength.weed, len(images)), overgrown, images)
        if self.strength.dashes:
            dashed = Dashes(self.generator, self.device).laid(images, boxes)
            images = torch.where(self.chance(self.strength.dashes, len(images)), dashed, images)
        return self.light(self.recorded(images)), compact(boxes)

    def recorded(self, x: torch.Tensor) -> torch.Tensor:
        """The picture as another recorder would show it: coarser speckle, a pulse that trails outward, a wide beam, a noise
        floor, another compression and gain over range. Means stay where they are, so that boxes hold."""
        s, count = self.strength, len(x)
        if s.grains:
            x = torch.where(self.chance(s.grains, count), x * self.coarse_speckle(x), x)
        if s.smear:
            x = torch.where(self.chance(s.smear, count), self.smeared(x), x)
        if s.along:
            x = torch.where(self.chance(s.along, count), self.smeared_along(x), x)
        if s.floor:
            level = self.uniform(count, 1, 1, 1, high=0.25) * x.mean((2, 3), keepdim=True)
            noise = (self.noise(*x.shape) ** 2 + self.noise(*x.shape) ** 2) / 2
            x = torch.where(self.chance(s.floor, count), (x**2 + level**2 * noise).sqrt(), x)
        if s.law:
            strength = self.log_uniform(count, 1, 1, 1, factor=3.0) * 4
            pressed = torch.log1p(x.clamp(min=0) * strength) / torch.log1p(strength)
            pressed = pressed * (x.mean((2, 3), keepdim=True) / pressed.mean((2, 3), keepdim=True).clamp(min=1e-6))
            x = torch.where(self.chance(s.law, count), pressed, x)
        if s.curve:
            knots = torch.exp(self.noise(count, 1, 1, 6) * 0.25)
            curve = F.interpolate(knots, size=(1, x.shape[-1]), mode="bicubic", align_corners=True)
            x = torch.where(self.chance(s.curve, count), x * curve, x)
        return x

    def chance(self, share: float, count: int) -> torch.Tensor:
        """Which pictures are chosen, `[count, 1, 1, 1]`."""
        return self.uniform(count, 1, 1, 1) < share

    def coarse_speckle(self, x: torch.Tensor) -> torch.Tensor:
        """Factors of mean 1 that are alike over one to four pixels of range: an amplitude of several looks."""
        count, _, rows, columns = x.shape
        size = 1 + int(self.uniform(1).item() * 4)
        few = -(-columns // size)
        power = sum(self.noise(count, 1, rows, few) ** 2 for _ in range(4)) / 4
        grains = power.sqrt().repeat_interleave(size, 3)[..., :columns]
        share = self.uniform(count, 1, 1, 1)
        return 1 + share * (grains - 1)

    def smeared(self, x: torch.Tensor) -> torch.Tensor:
        """Every echo trails outward over up to 0.3 m, shifted back by the delay of its mean."""
        length = self.log_uniform(len(x), factor=2.6) * 2.6
        taps = torch.arange(24, device=self.device)
        kernel = torch.exp(-taps / length[:, None])
        kernel = kernel / kernel.sum(1, keepdim=True)
        delay = (kernel * taps).sum(1).round().long()
        padded = F.pad(x[:, 0].unsqueeze(0), (23, 23, 0, 0), mode="replicate")
        out = F.conv2d(padded, kernel.flip(1)[:, None, None, :], groups=len(x))[0]
        at = torch.arange(x.shape[-1], device=self.device)[None] + delay[:, None]
        return out.gather(2, at[:, None].expand(-1, x.shape[2], -1)).unsqueeze(1)

    def smeared_along(self, x: torch.Tensor) -> torch.Tensor:
        """A wide beam: neighbouring pings are alike over up to some 0.2 m."""
        width = self.uniform(len(x), low=0.6, high=2.5)
        taps = torch.arange(-6, 7, device=self.device)
        kernel = torch.exp(-((taps / width[:, None]) ** 2) / 2)
        kernel = kernel / kernel.sum(1, keepdim=True)
        padded = F.pad(x[:, 0].unsqueeze(0), (0, 0, 6, 6), mode="replicate")
        return F.conv2d(padded, kernel[:, None, :, None], groups=len(x))[0].unsqueeze(1)

    def quadrants(self, count: int) -> torch.Tensor:
        """The four rectangles `[batch, 4, 4]` (x1, y1, x2, y2) of each picture; without a mosaic the first fills it."""
        side = float(self.side)
        split = self.uniform(count, 2, low=0.3, high=0.7) * side
        whole = self.uniform(count, 1) >= self.strength.mosaic
        x, y = torch.where(whole, torch.full_like(split, side), split).unbind(1)
        zero, full = torch.zeros_like(x), torch.full_like(x, side)
        rectangles = [(zero, zero, x, y), (x, zero, full, y), (zero, y, x, full), (x, y, full, full)]
        return torch.stack([torch.stack(r, 1) for r in rectangles], 1)

    def compose(self, index: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Places one chip, or parts of four, in each picture, scaled, shifted and mirrored along track."""
        count, side = len(index), self.side
        rectangles = self.quadrants(count)
        parts = 4 if self.strength.mosaic > 0 else 1
        out, boxes = torch.zeros(count, 1, side, side, device=self.device), []
        for part in range(parts):
            source = index if part == 0 else index[torch.randperm(count, generator=self.generator, device=self.device)]
            rectangle = rectangles[:, part]
            scale, offset, mirrored = self.placement(rectangle)
            if parts == 1 and self.focus:
                offset = self.around_objects(self.chips.boxes[source], scale, offset, mirrored)
            picture = sample(self.chips.images[source], scale, offset, mirrored, side)
            out = torch.where(inside(rectangle, side), picture, out)
            placed = place(self.chips.boxes[source], self.chips.edges[source], rectangle, scale, offset, mirrored, self.chips.side)
            boxes.append(placed)
        return out, torch.cat(boxes, 1)

    def placement(self, rectangle: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Scale and offset `[batch, 2]` (columns, rows) of a source chip in its rectangle, and whether rows are mirrored."""
        count, side, strength = len(rectangle), self.side, self.strength
        scale = self.log_uniform(count, 1, factor=strength.scale).repeat(1, 2)
        scale[:, 1] *= self.log_uniform(count, factor=strength.stretch)
        corner, size = rectangle[:, :2], rectangle[:, 2:] - rectangle[:, :2]
        offset = corner - self.uniform(count, 2) * (scale * self.chips.side - size)
        offset = offset + self.uniform(count, 2, low=-1.0, high=1.0) * strength.shift * side * (size >= side)
        return scale, offset, self.uniform(count) < 0.5

    def around_objects(self, boxes, scale, offset, mirrored) -> torch.Tensor:
        """The offsets that bring one object of each chip well into its picture; those given where it has none, or is left out."""
        count, here = len(boxes), boxes[..., 0] >= 0
        slot = (self.uniform(count, boxes.shape[1]) + here.float()).argmax(1)
        box = boxes[torch.arange(count, device=self.device), slot]
        centre = (box[:, 1:3] + box[:, 3:5]) / 2
        centre[:, 1] = torch.where(mirrored, self.chips.side - centre[:, 1], centre[:, 1])
        wanted = self.uniform(count, 2, low=0.2, high=0.8) * self.side - scale * centre
        # No black margin but where the chip is smaller than the picture.
        wanted = torch.minimum(torch.maximum(wanted, self.side - scale * self.chips.side), torch.zeros_like(wanted))
        chosen = here.any(1) & (self.uniform(count) < self.focus)
        return torch.where(chosen[:, None], wanted, offset)

    def light(self, x: torch.Tensor) -> torch.Tensor:
        """Gamma, gain, a slope over range, gain per ping, speckle, blur and lost pings."""
        count, _, rows, columns = x.shape
        s = self.strength
        x = x.clamp(0, 1) ** (1.0 + s.gamma) ** self.uniform(count, 1, 1, 1, low=-1.0, high=1.0)
        gain = torch.exp(self.uniform(count, 1, 1, 1, low=-1.0, high=1.0) * s.gain)
        outward = torch.linspace(-0.5, 0.5, columns, device=self.device).view(1, 1, 1, columns)
        ramp = torch.exp(self.uniform(count, 1, 1, 1, low=-1.0, high=1.0) * s.ramp * outward)
        x = x * gain * ramp * (1 + self.noise(count, 1, rows, 1) * self.uniform(count, 1, 1, 1) * s.row_gain)
        blurred = F.avg_pool2d(F.pad(x, (1, 1, 1, 1), mode="replicate"), 3, 1)
        x = torch.where(self.uniform(count, 1, 1, 1) < s.blur, blurred, x)
        x = x * (1 + self.noise(count, 1, rows, columns) * self.uniform(count, 1, 1, 1) * s.speckle)
        lost = self.uniform(count, 1, rows, 1) < 0.02 * (self.uniform(count, 1, 1, 1) < s.dropouts)
        return x.masked_fill(lost, 0.0).clamp(0, 1)

    def noise(self, *shape: int) -> torch.Tensor:
        """Seeded normal numbers on the device."""
        return torch.randn(*shape, generator=self.generator, device=self.device)


def sample(images: torch.Tensor, scale: torch.Tensor, offset: torch.Tensor, mirrored: torch.Tensor, side: int) -> torch.Tensor:
    """Draws each u8 chip into a picture of `side` pixels at `out = offset + scale * source`, rows mirrored first where asked.

    Black outside the chip.
    """
    count, source = images.shape[0], images.shape[-1]
    # grid_sample wants the inverse in coordinates of -1..1: source = (out - offset) / scale.
    factor = side / source / scale
    constant = (side / 2 - offset) / scale * 2 / source - 1
    sign = torch.stack([torch.ones_like(scale[:, 0]), torch.where(mirrored, -1.0, 1.0)], 1)
    theta = torch.zeros(count, 2, 3, device=images.device)
    theta[:, 0, 0], theta[:, 1, 1] = (factor * sign).unbind(1)
    theta[:, :, 2] = constant * sign
    grid = F.affine_grid(theta, [count, 1, side, side], align_corners=False)
    return F.grid_sample(images.unsqueeze(1).float() / 255, grid, align_corners=False)


def inside(rectangle: torch.Tensor, side: int) -> torch.Tensor:
    """Mask `[batch, 1, side, side]` of the pixels whose centre lies in the rectangle."""
    at = torch.arange(side, device=rectangle.device) + 0.5
    columns = (at >= rectangle[:, 0:1]) & (at < rectangle[:, 2:3])
    rows = (at >= rectangle[:, 1:2]) & (at < rectangle[:, 3:4])
    return (rows[:, :, None] & columns[:, None, :]).unsqueeze(1)


def place(boxes, edges, rectangle, scale, offset, mirrored, source: int) -> torch.Tensor:
    """Moves boxes as `sample` moves pixels, cuts the objects at the rectangle and demotes those that lose too much.

    The box of a cut object is that of the bands of its outline, and the parts of these, that remain.
    """
    kind, x1, y1, x2, y2 = boxes.unbind(-1)
    up = mirrored[:, None]
    y1, y2 = torch.where(up, source - y2, y1), torch.where(up, source - y1, y2)
    edges = torch.where(up[..., None, None], edges.flip(2), edges)
    (scale_x, scale_y), (shift_x, shift_y) = scale[:, :, None].unbind(1), offset[:, :, None].unbind(1)
    y1, y2 = y1 * scale_y + shift_y, y2 * scale_y + shift_y
    near, far = (edges * scale_x[..., None, None] + shift_x[..., None, None]).unbind(-1)
    left, top, right, bottom = (side[:, None] for side in rectangle.unbind(-1))
    # The rows of each band, whole and cut.
    steps = torch.arange(edges.shape[2] + 1, device=boxes.device) / edges.shape[2]
    rows = y1[..., None] + (y2 - y1)[..., None] * steps
    cut_rows = torch.minimum(torch.maximum(rows, top[..., None]), bottom[..., None])
    cut_near, cut_far = torch.maximum(near, left[..., None]), torch.minimum(far, right[..., None])
    height, width = cut_rows.diff(dim=-1), (cut_far - cut_near).clamp(min=0)
    share = (height * width).sum(-1) / (rows.diff(dim=-1) * (far - near).clamp(min=0)).sum(-1).clamp(min=1e-6)
    here = (height > 0) & (width > 0)

    def least(values: torch.Tensor) -> torch.Tensor:
        return torch.where(here, values, torch.full_like(values, 1e6)).amin(-1)

    cut = torch.stack([least(cut_near), least(cut_rows[..., :-1]), -least(-cut_far), -least(-cut_rows[..., 1:])], -1)
    size = cut[..., 2:] - cut[..., :2]
    gone = (kind == ABSENT) | (share < TRACE_SHARE) | ~here.any(-1)
    doubtful = (kind == IGNORE) | (share < TRUTH_SHARE) | (size.amin(-1) < SMALLEST_PX)
    kind = torch.where(gone, torch.full_like(kind, ABSENT), torch.where(doubtful, torch.full_like(kind, IGNORE), kind))
    return torch.cat([kind[..., None], torch.where(gone[..., None], torch.zeros_like(cut), cut)], -1)


def compact(boxes: torch.Tensor) -> torch.Tensor:
    """Drops the slots that no picture of the batch needs."""
    order = boxes[..., 0].argsort(dim=1, descending=True)
    boxes = boxes.gather(1, order[..., None].expand_as(boxes))
    used = int((boxes[..., 0] != ABSENT).sum(1).max())
    return boxes[:, : max(used, 1)]
