#!/usr/bin/env bash
# Mutants on the lines changed since BASE (the commit before the last unless given), within about 90 s: if there are more,
# a sample drawn from a seed. Fails if the core's quick tests detect fewer than nine of ten, counting those with a reason in
# equivalent.toml.
#     changed.sh [BASE]
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
cd "$here/../.."
base="${1:-HEAD~1}"
rooms=(limiter sample output compensation contour kinematics roundness exchange tcomp)
if ! git rev-parse --quiet --verify "$base^{commit}" >/dev/null; then
    echo "no commit $base to compare with: no mutants"
    exit
fi
diff="$(mktemp)"
trap 'rm -f "$diff"' EXIT
mapfile -t paths < <(printf 'crates/trueaxis/src/%s\n' "${rooms[@]}" "${rooms[@]/%/.rs}")
git diff --no-ext-diff "$base" -- "${paths[@]}" >"$diff"
if [[ ! -s $diff ]]; then
    echo "no line of ${rooms[*]} changed since $base: no mutants"
    exit
fi
"$here/run.sh" --in-diff "$diff" --seconds 90 --seed 1 --longest 0.3 --least 90 \
    --package trueaxis --tests=--lib --tests=--test --tests=plugin
