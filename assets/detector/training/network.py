"""YOLOv4 and YOLOv4-tiny for grey sonar chips, and the decoding of their heads.

The layouts follow the published Darknet configurations (`yolov4.cfg`, `yolov4-tiny.cfg`, `yolov4-tiny-3l.cfg` of
AlexeyAB/darknet), with one input channel and a width multiplier for YOLOv4. Every network returns its raw heads, finest
first: a list of `[batch, anchors * (5 + classes), rows, columns]`, in the order x, y, w, h, objectness, classes per anchor.
"""

import math

import torch
from torch import nn

# Darknet's `scale_x_y` per stride: how far beyond its cell a centre may reach.
CELL_REACH = {"yolov4": {8: 1.2, 16: 1.1, 32: 1.05}, "tiny": {16: 1.05, 32: 1.05}, "tiny3l": {8: 1.05, 16: 1.05, 32: 1.05}}
# exp(4) = 55 times the anchor: keeps an early, wild prediction finite.
LARGEST_LOG_GROWTH = 4.0


class Conv(nn.Sequential):
    """Convolution without bias, batch normalisation and an activation, as Darknet's `[convolutional]` with its defaults."""

    def __init__(self, inputs: int, outputs: int, size: int, stride: int = 1, mish: bool = False):
        activation = nn.Mish(inplace=True) if mish else nn.LeakyReLU(0.1, inplace=True)
        super().__init__(
            nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False),
            nn.BatchNorm2d(outputs, momentum=0.03, eps=1e-5),
            activation,
        )


def head_conv(inputs: int, anchors: int, classes: int) -> nn.Conv2d:
    """The last 1x1 convolution of a head. Its objectness starts near one in a hundred, so that training starts calm."""
    conv = nn.Conv2d(inputs, anchors * (5 + classes), 1)
    with torch.no_grad():
        conv.weight.normal_(0.0, 0.01)
        bias = conv.bias.view(anchors, 5 + classes)
        bias.zero_()
        bias[:, 4] = -math.log(99.0)
    return conv


class Residual(nn.Module):
    """1x1 then 3x3 convolution, added to the input."""

    def __init__(self, channels: int, hidden: int):
        super().__init__()
        self.body = nn.Sequential(Conv(channels, hidden, 1, mish=True), Conv(hidden, channels, 3, mish=True))

    def forward(self, x):
        return x + self.body(x)


class CspStage(nn.Module):
    """A cross-stage-partial stage of CSPDarknet53: halve the picture, send half the channels through the residual blocks."""

    def __init__(self, inputs: int, outputs: int, blocks: int, first: bool = False):
        super().__init__()
        part = outputs if first else outputs // 2
        self.down = Conv(inputs, outputs, 3, 2, mish=True)
        self.bypass = Conv(outputs, part, 1, mish=True)
        self.enter = Conv(outputs, part, 1, mish=True)
        hidden = part // 2 if first else part
        self.blocks = nn.Sequential(*(Residual(part, hidden) for _ in range(blocks)))
        self.leave = Conv(part, part, 1, mish=True)
        self.join = Conv(2 * part, outputs, 1, mish=True)

    def forward(self, x):
        x = self.down(x)
        deep = self.leave(self.blocks(self.enter(x)))
        return self.join(torch.cat([deep, self.bypass(x)], 1))


class Spp(nn.Module):
    """Spatial pyramid pooling: the picture beside its maxima over 13, 9 and 5 cells."""

    def __init__(self):
        super().__init__()
        self.pools = nn.ModuleList(nn.MaxPool2d(size, 1, size // 2) for size in (13, 9, 5))

    def forward(self, x):
        return torch.cat([pool(x) for pool in self.pools] + [x], 1)


def five(inputs: int, channels: int) -> nn.Sequential:
    """Darknet's run of five convolutions, 1x1 and 3x3 in turn, that ends on `channels`."""
    return nn.Sequential(
        Conv(inputs, channels, 1),
        Conv(channels, 2 * channels, 3),
        Conv(2 * channels, channels, 1),
        Conv(channels, 2 * channels, 3),
        Conv(2 * channels, channels, 1),
    )


class Yolov4(nn.Module):
    """YOLOv4: CSPDarknet53 (1-2-8-8-4 blocks, Mish), SPP, PANet and three YOLOv3 heads (leaky), all channels times `width`."""

    strides = (8, 16, 32)
    reach = CELL_REACH["yolov4"]

    def __init__(self, classes: int, width: float = 0.25, anchors_per_head: int = 3):
        super().__init__()

        def c(channels: int) -> int:
            return max(8, int(round(channels * width / 8)) * 8)

        self.stem = Conv(1, c(32), 3, mish=True)
        stages = [(32, 64, 1), (64, 128, 2), (128, 256, 8), (256, 512, 8), (512, 1024, 4)]
        self.stages = nn.ModuleList(
            CspStage(c(inputs), c(outputs), blocks, first=(index == 0)) for index, (inputs, outputs, blocks) in enumerate(stages)
        )
        self.before_spp = nn.Sequential(Conv(c(1024), c(512), 1), Conv(c(512), c(1024), 3), Conv(c(1024), c(512), 1))
        self.spp = Spp()
        self.after_spp = nn.Sequential(Conv(4 * c(512), c(512), 1), Conv(c(512), c(1024), 3), Conv(c(1024), c(512), 1))
        self.up = nn.Upsample(scale_factor=2, mode="nearest")
        self.narrow5, self.side4, self.merge4 = Conv(c(512), c(256), 1), Conv(c(512), c(256), 1), five(2 * c(256), c(256))
        self.narrow4, self.side3, self.merge3 = Conv(c(256), c(128), 1), Conv(c(256), c(128), 1), five(2 * c(128), c(128))
        self.down3, self.path4 = Conv(c(128), c(256), 3, 2), five(2 * c(256), c(256))
        self.down4, self.path5 = Conv(c(256), c(512), 3, 2), five(2 * c(512), c(512))
        self.heads = nn.ModuleList(
            nn.Sequential(Conv(c(inputs), c(2 * inputs), 3), head_conv(c(2 * inputs), anchors_per_head, classes))
            for inputs in (128, 256, 512)
        )

    def forward(self, x):
        x = self.stages[1](self.stages[0](self.stem(x)))
        c3 = self.stages[2](x)
        c4 = self.stages[3](c3)
        p5 = self.after_spp(self.spp(self.before_spp(self.stages[4](c4))))
        p4 = self.merge4(torch.cat([self.side4(c4), self.up(self.narrow5(p5))], 1))
        n3 = self.merge3(torch.cat([self.side3(c3), self.up(self.narrow4(p4))], 1))
        n4 = self.path4(torch.cat([self.down3(n3), p4], 1))
        n5 = self.path5(torch.cat([self.down4(n4), p5], 1))
        return [head(features) for head, features in zip(self.heads, (n3, n4, n5))]


class TinyStage(nn.Module):
    """The partial stage of YOLOv4-tiny: only the second half of the channels goes deeper."""

    def __init__(self, channels: int):
        super().__init__()
        self.a = Conv(channels, channels, 3)
        self.b = Conv(channels // 2, channels // 2, 3)
        self.d = Conv(channels // 2, channels // 2, 3)
        self.e = Conv(channels, channels, 1)
        self.pool = nn.MaxPool2d(2, 2)

    def forward(self, x):
        """Returns the pooled output and the features before pooling that the next finer head takes."""
        a = self.a(x)
        first = self.b(a[:, a.shape[1] // 2 :])
        inner = self.e(torch.cat([self.d(first), first], 1))
        return self.pool(torch.cat([a, inner], 1)), inner


class Yolov4Tiny(nn.Module):
    """YOLOv4-tiny with two heads (strides 16 and 32) or, as `tiny3l`, a third one at stride 8 for small objects."""

    def __init__(self, classes: int, fine_head: bool = False, anchors_per_head: int = 3):
        super().__init__()
        self.strides = (8, 16, 32) if fine_head else (16, 32)
        self.reach = CELL_REACH["tiny3l" if fine_head else "tiny"]
        self.c0, self.c1 = Conv(1, 32, 3, 2), Conv(32, 64, 3, 2)
        self.stages = nn.ModuleList(TinyStage(channels) for channels in (64, 128, 256))
        self.c5, self.neck = Conv(512, 512, 3), Conv(512, 256, 1)
        self.head32 = nn.Sequential(Conv(256, 512, 3), head_conv(512, anchors_per_head, classes))
        self.up = nn.Upsample(scale_factor=2, mode="nearest")
        self.narrow16, self.deep16 = Conv(256, 128, 1), Conv(384, 256, 3)
        self.head16 = head_conv(256, anchors_per_head, classes)
        self.narrow8 = Conv(256, 64, 1) if fine_head else None
        self.head8 = nn.Sequential(Conv(192, 128, 3), head_conv(128, anchors_per_head, classes)) if fine_head else None

    def backbone_convs(self) -> list[Conv]:
        """The convolutions of Darknet's `yolov4-tiny.conv.29`, in file order."""
        convs = [self.c0, self.c1]
        for stage in self.stages:
            convs += [stage.a, stage.b, stage.d, stage.e]
        return convs + [self.c5, self.neck, self.head32[0]]

    def forward(self, x):
        x, _ = self.stages[0](self.c1(self.c0(x)))
        x, fine = self.stages[1](x)
        x, middle = self.stages[2](x)
        neck = self.neck(self.c5(x))
        deep16 = self.deep16(torch.cat([self.up(self.narrow16(neck)), middle], 1))
        heads = [self.head16(deep16), self.head32(neck)]
        if self.head8 is not None:
            heads.insert(0, self.head8(torch.cat([self.up(self.narrow8(deep16)), fine], 1)))
        return heads


def build(name: str, classes: int, width: float = 0.25) -> nn.Module:
    """The network called `name`: `yolov4` (with `width`), `tiny` or `tiny3l`."""
    if name == "yolov4":
        return Yolov4(classes, width)
    if name in ("tiny", "tiny3l"):
        return Yolov4Tiny(classes, fine_head=(name == "tiny3l"))
    raise SystemExit(f"unknown network `{name}`: choose yolov4, tiny or tiny3l")


def decode_level(head: torch.Tensor, anchors: torch.Tensor, stride: int, reach: float):
    """One raw head in pixels of the chip.

    x = (column + reach * sigmoid(tx) - (reach - 1) / 2) * stride, w = anchor_w * exp(tw) (Darknet, `yolo_layer.c`).
    `anchors` is `[anchors, 2]` in pixels. Returns centres and sizes `[batch, anchors, rows, columns, 4]` and the logits of
    objectness and classes `[batch, anchors, rows, columns, 1 + classes]`.
    """
    batch, channels, rows, columns = head.shape
    count = anchors.shape[0]
    head = head.view(batch, count, channels // count, rows, columns).permute(0, 1, 3, 4, 2)
    column = torch.arange(columns, device=head.device, dtype=head.dtype).view(1, 1, 1, columns)
    row = torch.arange(rows, device=head.device, dtype=head.dtype).view(1, 1, rows, 1)
    within = head[..., 0:2].sigmoid() * reach - (reach - 1.0) / 2.0
    size = head[..., 2:4].clamp(max=LARGEST_LOG_GROWTH).exp() * anchors.to(head.dtype).view(1, count, 1, 1, 2)
    centre = torch.stack([(within[..., 0] + column) * stride, (within[..., 1] + row) * stride], -1)
    return torch.cat([centre, size], -1), head[..., 4:]


class Decoded(nn.Module):
    """A network whose heads are decoded inside the graph, as Tianxiaomo's pytorch-YOLOv4 exports them.

    Outputs `boxes [batch, n, 1, 4]` (x1, y1, x2, y2 as fractions of the chip) and `confs [batch, n, classes]`
    (objectness times class probability).
    """

    def __init__(self, network: nn.Module, anchors: torch.Tensor, side: int):
        super().__init__()
        self.network, self.side = network, side
        self.register_buffer("anchors", anchors.clone().float())

    def forward(self, x):
        boxes, confs = [], []
        for level, head in enumerate(self.network(x)):
            stride = self.network.strides[level]
            box, logits = decode_level(head.float(), self.anchors[level], stride, self.network.reach[stride])
            box = box.reshape(box.shape[0], -1, 4) / self.side
            logits = logits.reshape(logits.shape[0], -1, logits.shape[-1]).sigmoid()
            half = box[..., 2:] / 2
            boxes.append(torch.cat([box[..., :2] - half, box[..., :2] + half], -1))
            confs.append(logits[..., :1] * logits[..., 1:])
        return torch.cat(boxes, 1).unsqueeze(2), torch.cat(confs, 1)
