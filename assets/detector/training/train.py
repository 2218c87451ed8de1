"""Trains a detector on simulated chips, with real tiles mixed in, then measures and exports it.

    python train.py --data DIR --network tiny --init coco_tiny.npz --minutes 7 --out OUT [--real real.npz]
    python train.py --data DIR --network yolov4 --width 0.25 --minutes 8 --out OUT [--real real.npz]

The learning rate follows a cosine over the wall clock (`--minutes`, stops left out) or over `--steps`, whichever is nearer its
end; with `--steps` alone a run on the CPU repeats exactly. `--state FILE` keeps a checkpoint from which the same command goes on.
OUT receives NAME.onnx, NAME.json, metrics.json, errors.json, errors.png, log.csv and weights.npz.
"""

import argparse
import copy
import csv
import json
import math
import time
from dataclasses import asdict
from pathlib import Path

import numpy as np
import torch

import real
from anchors import per_head, size_iou
from augment import Augmenter, Strength
from boulders import ROCK
from darknet_weights import load_coco
from data import DEFAULT_PIXEL_M, Chips, has_split, holding, join, read_manifest, read_names, read_split, used_names
from detect import detect, judged, suppress, truths
from evaluate import evaluate
from export import export
from loss import Yolov4Loss
from metrics import precision_table
from network import build
from weights import fill, read_meta, save_weights

WARMUP = 0.03  # share of the run over which the learning rate rises
LAST_RATE = 0.01  # final learning rate as a share of the first
EMA_KEEP = 0.999
CLIP_NORM = 20.0
LOG_SECONDS = 10.0
LOG_COLUMNS = ("step", "seconds", "rate", "total", "box", "object", "class", "chips_per_second", "map50")
UNSEEN_LOSS, MOST_LOSS = 5.0, 10.0  # of a chip that has not been drawn yet, and the most that counts
LONGEST_WAIT = 5.0  # seconds that a step may wait for a device without work of the processor
LOOK_CHIPS = 400  # validation chips for the looks during training


class Trainer:
    """A network in training, its running average and everything a checkpoint must hold."""

    def __init__(self, network, anchors: list, args, device):
        self.args, self.device = args, device
        self.network = network.to(device, memory_format=torch.channels_last)
        self.average = copy.deepcopy(self.network).eval()
        self.loss = Yolov4Loss([torch.tensor(a, device=device) for a in anchors], network.strides, network.reach)
        self.forward = torch.compile(self.network) if args.compile else self.network
        decayed = [p for p in self.network.parameters() if p.ndim == 4]
        plain = [p for p in self.network.parameters() if p.ndim != 4]
        groups = [{"params": decayed, "weight_decay": args.decay}, {"params": plain, "weight_decay": 0.0}]
        self.optimizer = torch.optim.AdamW(groups, lr=args.rate, betas=(0.9, 0.99), fused=(device.type == "cuda"))
        self.generator = torch.Generator(device).manual_seed(args.seed)
        self.steps, self.seconds = 0, 0.0

    def progress(self) -> float:
        """How much of the run is over, 0 to 1."""
        by_clock = self.seconds / (self.args.minutes * 60) if self.args.minutes else 0.0
        by_steps = self.steps / self.args.steps if self.args.steps else 0.0
        return min(1.0, max(by_clock, by_steps))

    def rate(self) -> float:
        """The learning rate now: a linear rise, then half a cosine."""
        done = self.progress()
        if done < WARMUP:
            return self.args.rate * max(done / WARMUP, 1e-3)
        fall = (1 + math.cos(math.pi * (done - WARMUP) / (1 - WARMUP))) / 2
        return self.args.rate * (LAST_RATE + (1 - LAST_RATE) * fall)

    def step(self, images: torch.Tensor, boxes: torch.Tensor) -> dict[str, torch.Tensor]:
        """One update; returns the loss terms, still on the device."""
        for group in self.optimizer.param_groups:
            group["lr"] = self.rate()
        images = images.contiguous(memory_format=torch.channels_last)
        with torch.autocast(self.device.type, torch.bfloat16, enabled=not self.args.float32):
            heads = self.forward(images)
        terms = self.loss(heads, boxes)
        self.optimizer.zero_grad(set_to_none=True)
        terms["total"].backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), CLIP_NORM)
        self.optimizer.step()
        self.steps += 1
        self.follow()
        return {name: value.detach() for name, value in terms.items()}

    @torch.no_grad()
    def follow(self) -> None:
        """Moves the running average towards the network, quickly at first."""
        keep = min(EMA_KEEP, (1 + self.steps) / (10 + self.steps))
        ours, theirs = self.average.state_dict(), self.network.state_dict()
        floats = [name for name, value in ours.items() if value.is_floating_point()]
        torch._foreach_lerp_([ours[name] for name in floats], [theirs[name] for name in floats], 1 - keep)

    def save(self, path: Path) -> None:
        """Writes the checkpoint aside, then in place, so that a stop leaves the old one."""
        parts = {"network": self.network, "average": self.average, "optimizer": self.optimizer}
        state = {name: part.state_dict() for name, part in parts.items()}
        state |= {"steps": self.steps, "seconds": self.seconds, "random": self.generator.get_state()}
        aside = path.with_suffix(".part")
        torch.save(state, aside)
        aside.replace(path)

    def load(self, path: Path) -> None:
        """Goes on from a checkpoint."""
        state = torch.load(path, map_location=self.device)
        for name in ("network", "average", "optimizer"):
            getattr(self, name).load_state_dict(state[name])
        self.generator.set_state(state["random"].cpu())
        self.steps, self.seconds = state["steps"], state["seconds"]


def strength_of(args) -> Strength:
    """How far pictures are varied."""
    strength = Strength(mosaic=args.mosaic, weed=args.weed, boulders=args.boulders, dashes=args.dashes)
    return strength.of_other_recorders() if args.recorders else strength


class Batches:
    """Endless varied batches, a fixed share of them from real chips."""

    def __init__(self, synthetic: Chips, real_chips: Chips | None, args, generator: torch.Generator, rock: int):
        self.sources = [(synthetic, args.batch)]
        if real_chips is not None and args.real_share > 0:
            count = round(args.batch * args.real_share)
            self.sources = [(synthetic, args.batch - count), (real_chips, count)]
        self.generator, self.strength, self.rock = generator, strength_of(args), rock
        self.calm, self.side, self.occupied, self.focus = False, args.crop, args.occupied, args.focus
        # What each simulated chip's loss was when it was last seen, the first time soon.
        self.hard, self.losses, self.drawn = args.hard, torch.full((len(synthetic),), UNSEEN_LOSS, device=args.device), None
        self.folders = None
        if args.shares:
            folder = torch.tensor([int(name.split("/")[0]) for name in synthetic.names], device=args.device)
            chosen = torch.nn.functional.one_hot(folder, len(args.shares)).float().T
            self.folders = chosen, torch.tensor(args.shares, device=args.device)
        self.holding = {id(chips): torch.nonzero((chips.boxes[..., 0] >= 0).any(1))[:, 0] for chips, _ in self.sources}

    def next(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Pictures and boxes of one batch."""
        strength, images, boxes = self.strength.calm() if self.calm else self.strength, [], []
        for chips, count in self.sources:
            index = self.draw(chips, count)
            if chips is self.sources[0][0]:
                self.drawn = index
            picture, box = Augmenter(chips, strength, self.generator, self.side, self.focus, self.rock).batch(index)
            images.append(picture)
            boxes.append(box)
        slots = max(b.shape[1] for b in boxes)
        boxes = [torch.nn.functional.pad(b, (0, 0, 0, slots - b.shape[1]), value=-2.0) for b in boxes]
        return torch.cat(images), torch.cat(boxes)

    def draw(self, chips: Chips, count: int) -> torch.Tensor:
        """Chips for a batch: of simulated ones the share `--hard` by their loss; of the rest the share `--occupied` from those
        that hold an object."""
        device, holding = chips.images.device, self.holding[id(chips)]
        if self.folders and chips is self.sources[0][0]:
            return self.by_folder(count, holding)
        index = torch.randint(len(chips), (count,), generator=self.generator, device=device)
        if self.occupied and len(holding):
            other = holding[torch.randint(len(holding), (count,), generator=self.generator, device=device)]
            index = self.either(self.occupied, other, index)
        if self.hard and chips is self.sources[0][0]:
            index = self.either(self.hard, torch.multinomial(self.losses, count, replacement=True, generator=self.generator), index)
        return index

    def by_folder(self, count: int, holding: torch.Tensor) -> torch.Tensor:
        """The same with the share of each folder that `--shares` sets, whatever the number of its chips."""
        chosen, shares = self.folders

        def drawn(weight: torch.Tensor) -> torch.Tensor:
            each = chosen * weight
            each = (each / each.sum(1, keepdim=True).clamp(min=1e-9) * shares[:, None]).sum(0)
            return torch.multinomial(each, count, replacement=True, generator=self.generator)

        index, held = drawn(torch.ones_like(self.losses)), torch.zeros_like(self.losses)
        held[holding] = 1
        if self.occupied:
            index = self.either(self.occupied, drawn(held), index)
        return self.either(self.hard, drawn(self.losses), index) if self.hard else index

    def either(self, share: float, one: torch.Tensor, other: torch.Tensor) -> torch.Tensor:
        """Takes each entry from `one` with the probability `share`, else from `other`."""
        return torch.where(torch.rand(len(one), generator=self.generator, device=one.device) < share, one, other)

    def learn(self, losses: torch.Tensor) -> None:
        """Hears the losses of the last batch, picture by picture; simulated chips come first. What counts is the mean with the
        one before, as a cut-out may have passed over what is hard."""
        before, now = self.losses[self.drawn], losses[: len(self.drawn)].clamp(max=MOST_LOSS)
        self.losses[self.drawn] = torch.where(before == UNSEEN_LOSS, now, (before + now) / 2)


def look(trainer: Trainer, chips: Chips, meta: dict) -> float:
    """mAP50 of the running average on some validation chips."""
    found = judged([suppress(rows, agnostic=False) for rows in detect(trainer.average, meta["anchors"], chips)], chips)
    return precision_table(found, truths(chips), meta["names"], ious=(0.5,))["map50"]


class Clock:
    """Time that a training had, by the clock: what it spends stopped (`kill -STOP`, a machine asleep) is not its own."""

    def __init__(self):
        self.wall, self.processor = time.monotonic(), time.process_time()

    def lap(self) -> float:
        """Seconds since the last lap; of a long one without work those that the processor was busy."""
        wall, processor = time.monotonic(), time.process_time()
        spent, busy = wall - self.wall, processor - self.processor
        self.wall, self.processor = wall, processor
        return min(spent, max(busy, LONGEST_WAIT))


class Log:
    """Lines of progress, printed and kept as CSV, every ten seconds and at each look at the validation chips."""

    def __init__(self, file):
        self.file, self.writer = file, csv.writer(file)
        self.chips, self.since = 0, time.monotonic()
        if not file.tell():
            self.writer.writerow(LOG_COLUMNS)

    def due(self) -> bool:
        """Whether the last line is ten seconds old."""
        return time.monotonic() - self.since > LOG_SECONDS

    def line(self, trainer: Trainer, terms: dict[str, torch.Tensor], precision: float | None) -> None:
        """Writes one line; reading the terms waits for the device."""
        values = [round(float(terms[name]), 4) for name in ("total", "box", "object", "class")]
        speed = round(self.chips / (time.monotonic() - self.since))
        self.writer.writerow([trainer.steps, round(trainer.seconds, 1), f"{trainer.rate():.2e}", *values, speed, precision])
        self.file.flush()
        print(f"step {trainer.steps} at {trainer.seconds:.0f} s: loss {values}, {speed} chips/s, mAP50 {precision}", flush=True)
        self.chips, self.since = 0, time.monotonic()


def run(trainer: Trainer, batches: Batches, val: Chips, meta: dict, log: Log) -> None:
    """Trains until the budget is spent; looks at the validation chips, and keeps weights and checkpoint, now and then."""
    args, looks = trainer.args, int(trainer.progress() * trainer.args.looks)
    clock, kept = Clock(), time.monotonic()
    while trainer.progress() < 1.0:
        batches.calm = trainer.progress() > 1 - args.settle
        trainer.network.train()
        if args.still:
            for module in trainer.network.modules():
                if isinstance(module, torch.nn.BatchNorm2d):
                    module.eval()
        terms = trainer.step(*batches.next())
        batches.learn(terms["each"])
        log.chips += args.batch
        if trainer.progress() * args.looks >= looks + 1:
            looks = int(trainer.progress() * args.looks)
            log.line(trainer, terms, look(trainer, val, meta))
            save_weights(trainer.average, meta, args.out / "weights.npz")
        elif log.due():
            log.line(trainer, terms, None)
        if args.state and time.monotonic() - kept > args.keep_seconds:
            trainer.save(args.state)
            kept = time.monotonic()
        trainer.seconds += clock.lap()
    if args.state:
        trainer.save(args.state)


def starting_network(args, names: list[str]) -> tuple[torch.nn.Module, str]:
    """The network, from scratch or from `--init` (the COCO cut, or a `weights.npz` of ours), and a sentence about it."""
    torch.manual_seed(args.seed)
    network = build(args.network, len(names), args.width)
    if not args.init:
        return network, "from scratch"
    if read_meta(args.init):
        missed = fill(network, args.init)
        return network, f"from {Path(args.init).name}, {len(missed)} arrays anew"
    if args.network == "yolov4":
        raise SystemExit("the COCO weights are of YOLOv4-tiny: use them with --network tiny or tiny3l")
    load_coco(network, args.init)
    return network, "backbone from the official YOLOv4-tiny COCO weights (yolov4-tiny.conv.29)"


def arguments() -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--data", type=Path, required=True, nargs="+", help="folders written by `bathyscope simulate --dataset` or `bathyscope review`")
    add("--test", type=Path, help="folder whose test split is measured (default: the first of --data)")
    add("--out", type=Path, required=True, help="folder for the results")
    add("--network", default="tiny", choices=["tiny", "tiny3l", "yolov4"])
    add("--width", type=float, default=0.25, help="channels of yolov4, as a share of the published ones")
    add("--name", help="name of the exported files (default: the network's)")
    add("--init", help="coco_tiny.npz or a weights.npz to start from")
    add("--real", type=Path, help="real.npz written by real_tiles.py: measured, and trained on with --real-share")
    add("--real-share", type=float, default=0.15, help="share of each batch from real tiles")
    add("--leave-out", type=int, nargs="*", help="sessions of the real tiles that are measured, all others trained on (default: the split of real_tiles.py)")
    add("--minutes", type=float, default=0.0, help="budget of wall-clock time for training")
    add("--steps", type=int, default=0, help="budget of updates")
    add("--batch", type=int, default=64)
    add("--rate", type=float, default=1e-3, help="highest learning rate (AdamW)")
    add("--decay", type=float, default=0.01, help="weight decay of the convolutions")
    add("--crop", type=int, help="learn from cut-outs of this many pixels (a multiple of 32) at the same scale: faster")
    add("--occupied", type=float, default=0.0, help="share of each batch drawn from chips that hold an object")
    add("--hard", type=float, default=0.0, help="share of each batch drawn by the loss that a simulated chip had when last seen")
    add("--focus", type=float, default=0.0, help="with --crop and no mosaic: share of the chips with objects that are cut around one")
    add("--still", action="store_true", help="normalise by the statistics of --init throughout, not by those of a batch")
    add("--shares", type=float, nargs="+", help="share of each folder of --data among the simulated chips of a batch (default: by their numbers)")
    add("--mosaic", type=float, default=0.3, help="share of pictures made of four chips")
    add("--recorders", action="store_true", help="also vary what differs between recorders: smear, beam, floor, law, gain, speckle")
    add("--weed", type=float, default=0.0, help="share of pictures with beds of water weed laid over them, which are no objects")
    add("--boulders", type=float, default=0.0, help="share of pictures with fields of boulders laid over them, which are rocks")
    add("--dashes", type=float, default=0.0, help="share of pictures with dark dashes laid over them, as of fish, which are no objects")
    add("--settle", type=float, default=0.2, help="last share of the run, with little augmentation")
    add("--looks", type=int, default=6, help="how often to measure mAP50 on validation chips")
    add("--state", type=Path, help="checkpoint file to keep and to go on from")
    add("--keep-seconds", type=float, default=60.0)
    add("--limit", type=int, help="read only so many chips of each split")
    add("--seed", type=int, default=1)
    add("--threads", type=int, default=0, help="CPU threads of torch (0: its own choice)")
    add("--device", default="cuda" if torch.cuda.is_available() else "cpu")
    add("--compile", action="store_true", help="torch.compile the network (a minute's start)")
    add("--float32", action="store_true", help="no bf16 autocast")
    args = parser.parse_args()
    if not args.minutes and not args.steps:
        parser.error("give a budget: --minutes or --steps")
    return args


def prepare(args) -> tuple[Chips, Chips, Chips, "real.Tiles | None", dict]:
    """Reads all data and settles what the network must know: names, anchors, resolution."""
    began = time.monotonic()
    # Classes are the same where their names are. Every analyst has a list of their own: of the others' classes those count that boxes have.
    names = read_names(args.data[0])
    names += [name for root in args.data[1:] for name in used_names(root) if name not in names]
    names = list(dict.fromkeys(names))
    train, val = (join([read_split(root, split, args.limit, names) for root in holding(args.data, split)]) for split in ("train", "val"))
    held = args.test or args.data[0]
    test = read_split(held, "test", args.limit, names) if has_split(held, "test") else val
    if test is val:
        print("no test chips there: the validation chips are measured in their place", flush=True)
    tiles = real.read_tiles(args.real) if args.real else None
    if tiles is not None and args.leave_out is not None:
        real.leave_out(tiles, args.leave_out)
    manifest, rows = read_manifest(args.data[0]), train.boxes[train.boxes[..., 0] >= 0].numpy()
    heads = 2 if args.network == "tiny" else 3
    sizes = rows[:, 3:5] - rows[:, 1:3]
    earlier = read_meta(args.init) if args.init else {}
    # A network of ours has learnt its sizes beside its own anchors.
    anchors = earlier["anchors"] if earlier.get("network") == args.network else per_head(sizes, heads, args.seed)
    fit = size_iou(sizes, np.array(anchors).reshape(-1, 2)).max(1).mean()
    meta = {
        "name": args.name or args.network, "network": args.network, "width": args.width if args.network == "yolov4" else 1.0,
        "names": names, "anchors": anchors, "side": train.side,
        "pixel_m": manifest.get("pixel_m", DEFAULT_PIXEL_M),
    }  # fmt: skip
    spent = time.monotonic() - began
    print(
        f"{len(train)} + {len(val)} + {len(test)} chips, {len(rows)} boxes, anchors fit {fit:.3f}, read in {spent:.1f} s",
        flush=True,
    )
    return train, val, test, tiles, meta


def provenance(args, trainer: Trainer, chips: dict[str, int], start: str) -> dict:
    """How the network came about, for the sidecar and the model card."""
    return {
        "start": start, "steps": trainer.steps, "seconds": round(trainer.seconds, 1), "batch": args.batch, "rate": args.rate,
        "decay": args.decay, "seed": args.seed, "device": torch.cuda.get_device_name() if args.device == "cuda" else "cpu",
        "torch": torch.__version__, "augmentation": asdict(strength_of(args)), "settle": args.settle, "occupied": args.occupied,
        "crop": args.crop, "focus": args.focus, "hard": args.hard, "shares": args.shares, "still": args.still,
        "real_share": args.real_share if args.real else 0.0, "leave_out": args.leave_out, "chips": chips, "data": [read_manifest(root) for root in args.data],
    }  # fmt: skip


def summary(name: str, report: dict) -> str:
    """The figures that decide, in a few lines."""
    test, at = report["test"]["precision"], report["test"]["at_score"]
    lines = [
        f"{name}: test mAP50 {test['map50']:.4f}, mAP50:95 {test['map50_95']:.4f}, IoU of matches {at['mean_iou_of_matches']:.3f}",
        f"  at {at['score']}: {at['tp']} found, {at['fp']} false ({at['false_alarms_per_hectare']:.2f}/ha), {at['fn']} missed",
        "  AP50 " + ", ".join(f"{kind} {row['ap50']:.3f}" for kind, row in test["classes"].items()),
        "  "
        + ", ".join(f"{size['found']}/{size['truths']} from {size['from_m']:.1f} m" for size in report["test"]["recall_by_size"]),
    ]
    for split, kinds in report.get("real", {}).items():
        if split != "plain":
            lines.append(f"  real {split} AP50 " + ", ".join(f"{k} {v['ap50']:.3f} ({v['truths']})" for k, v in kinds.items()))
    return "\n".join([*lines, f"  export {report['export']}"])


def main() -> None:
    """Trains, measures, exports."""
    args = arguments()
    if args.threads:
        torch.set_num_threads(args.threads)
    torch.backends.cudnn.benchmark = True
    torch.set_float32_matmul_precision("high")
    device = torch.device(args.device)
    args.out.mkdir(parents=True, exist_ok=True)
    train, val, test, tiles, meta = prepare(args)
    network, start = starting_network(args, meta["names"])
    trainer = Trainer(network, meta["anchors"], args, device)
    if args.state and args.state.exists():
        trainer.load(args.state)
        start += f", gone on from step {trainer.steps}"
    real_chips = None
    if tiles is not None and args.real_share > 0:
        real_chips = real.packed_chips(tiles, 1500, meta, args.seed).to(device)
    names = meta["names"]
    batches = Batches(train.to(device), real_chips, args, trainer.generator, names.index(ROCK) if ROCK in names else 0)
    with open(args.out / "log.csv", "a", newline="") as log:
        run(trainer, batches, val.first(LOOK_CHIPS), meta, Log(log))
    sizes = {"train": len(train), "val": len(val), "test": len(test)}
    meta["training"] = provenance(args, trainer, sizes, start)
    report = evaluate(trainer.average, meta, val, test, tiles, args.out)
    meta["thresholds"] = {"score": report["score"], "iou": 0.45, "nms": "plain", "class_agnostic": True, "vote": 0.65}
    save_weights(trainer.average, meta, args.out / "weights.npz")
    chips = test.images[:4].unsqueeze(1).numpy().astype(np.float32) / 255
    report["export"] = export(trainer.average, meta, args.out, chips)
    (args.out / "metrics.json").write_text(json.dumps(report, indent=1) + "\n")
    print(summary(meta["name"], report))


if __name__ == "__main__":
    main()
