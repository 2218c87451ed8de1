"""Small dark dashes laid over pictures: the shadows of fish, whose echoes lie apart from them or not at all. They are no objects."""

import torch

MOST = 5
# Length and width, pixels of 0.04 m, and how dark the middle is.
LENGTH_PX, WIDTH_PX, DARK = (8.0, 30.0), (2.5, 6.0), (0.4, 0.9)
# A shadow on the ground runs outward: a dash that runs outward within this angle could be one.
LEAST_ANGLE_RAD = 0.25


class Dashes:
    """Draws dashes with a seeded generator on a device."""

    def __init__(self, generator: torch.Generator, device):
        self.generator, self.device = generator, device

    def uniform(self, count: int, low: float, high: float) -> torch.Tensor:
        """Seeded uniform numbers `[count, 1, 1]`."""
        return torch.rand(count, 1, 1, generator=self.generator, device=self.device) * (high - low) + low

    def laid(self, images: torch.Tensor, boxes: torch.Tensor) -> torch.Tensor:
        """The pictures `[count, 1, side, side]` with up to `MOST` dashes each, none on a box of `boxes [count, slots, 5]`."""
        count, side = len(images), images.shape[-1]
        at = torch.arange(side, device=self.device) + 0.5
        columns, rows = at.view(1, 1, side), at.view(1, side, 1)
        light = torch.ones(count, side, side, device=self.device)
        for _ in range(MOST):
            x, y = self.uniform(count, 0, side), self.uniform(count, 0, side)
            angle = self.uniform(count, LEAST_ANGLE_RAD, torch.pi - LEAST_ANGLE_RAD)
            length, width = self.uniform(count, *LENGTH_PX), self.uniform(count, *WIDTH_PX)
            along = (columns - x) * angle.cos() + (rows - y) * angle.sin()
            across = (rows - y) * angle.cos() - (columns - x) * angle.sin()
            shape = torch.exp(-((2 * along / length) ** 4) - (2 * across / width) ** 2)
            reach = length[:, 0]
            near = (boxes[..., 1] - reach < x[:, 0]) & (x[:, 0] < boxes[..., 3] + reach)
            near &= (boxes[..., 2] - reach < y[:, 0]) & (y[:, 0] < boxes[..., 4] + reach)
            is_free = ~(near & (boxes[..., 0] >= -1)).any(1)
            strength = self.uniform(count, *DARK) * is_free.view(count, 1, 1)
            light = light * (1 - strength * shape)
        return images * light.unsqueeze(1)
