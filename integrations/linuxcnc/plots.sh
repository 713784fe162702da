#!/usr/bin/env bash
# Records the runs shown in docs/controllers/linuxcnc.md and draws them into plots/. Needs the same as test.sh.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

root=$(cd ../.. && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
runs=$(mktemp -d)
trap 'rm -rf "$runs"' EXIT
TRUEAXIS_KEEP=$runs ./test.sh program switching contour
mkdir -p plots
draw() { "$target/release/linuxcnc-recording" plot "$@"; }

commands='mm; X command = joint.0.pos-cmd; Y = joint.1.pos-cmd; Z = joint.2.pos-cmd'
corrections='µm*1000'
for joint in 0:X 1:Y 2:Z; do
    n=${joint%:*}
    corrections+="; correction of ${joint#*:} = ta.joint.$n.motor-pos-cmd-out - joint.$n.motor-pos-cmd"
done

draw "$runs/program/run" plots/program.svg --from-s 0.5 --to-s 15 \
    --panel "$commands" \
    --panel "$corrections" \
    --panel 'nm*1000000; following error of X = joint.0.f-error'
draw "$runs/switching/run" plots/switching.svg --from-s 0.5 \
    --panel 'mm; X command = joint.0.pos-cmd' \
    --panel "$corrections" \
    --panel '; active = ta.active; reloads = ta.reloads; reload-failed = ta.reload-failed'
draw "$runs/contour/run" plots/contour.svg --from-s 0.5 \
    --panel 'mm; X command = joint.0.pos-cmd; Y = joint.1.pos-cmd' \
    --panel 'µm*1000; encoder = ta.contour.encoder.error; tip = ta.contour.tip.error' \
    --panel 'mm; lag = ta.contour.tip.lag'
