#!/bin/sh
# Trains several networks side by side on one GPU and packs what they leave into few files:
#
#     sh runs.sh CHIPS REAL.npz COCO.npz MINUTES OUT RUN...
#
# RUN is `tiny`, `tiny3l` or `yolov4`, followed by `_scratch` (no COCO weights; yolov4 has none anyway) and `_synthetic`
# (no real tiles in training), in that order. OUT receives RUN.onnx and RUN.npz (weights) of the first two runs, and
# results.tgz with every run's sidecar, metrics, errors, log and printed lines. `MORE` adds options to every run.
set -eu
here=$(dirname "$0")
chips=$1 real=$2 coco=$3 minutes=$4 out=$5
shift 5
work=$(mktemp -d)
trainings=
mkdir -p "$out"

for run in "$@"; do
    network=${run%%_*}
    set -- --network "$network"
    case $run in yolov4* | *_scratch*) ;; *) set -- "$@" --init "$coco" ;; esac
    case $run in *_synthetic) set -- "$@" --real-share 0 ;; esac
    mkdir "$work/$run"
    # shellcheck disable=SC2086 # MORE holds several words
    PYTHONUNBUFFERED=1 python3 "$here/train.py" --data "$chips" --real "$real" --minutes "$minutes" --name "$run" \
        --out "$work/$run" "$@" ${MORE:-} >"$work/$run/printed.txt" 2>&1 &
    trainings="$trainings $!"
    echo "$run" >>"$work/names"
done
# Weights so far, in case the time runs out before the end.
keep_weights() {
    head -n 2 "$work/names" | while read -r run; do
        [ ! -f "$work/$run/weights.npz" ] || cp "$work/$run/weights.npz" "$out/$run.npz"
    done
}
(while sleep 20; do keep_weights && tail -qn 1 "$work"/*/printed.txt; done) &
ticker=$!
# shellcheck disable=SC2086 # several process ids
wait $trainings || true
kill "$ticker"

keep_weights
head -n 2 "$work/names" | while read -r run; do
    cp "$work/$run/$run.onnx" "$out/" || echo "$run left no model"
done
tail -qn 8 "$work"/*/printed.txt
tar -C "$work" --exclude='*.onnx' --exclude='*.npz' -czf "$out/results.tgz" .
rm -r "$work"
