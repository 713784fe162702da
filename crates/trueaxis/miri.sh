#!/usr/bin/env bash
# Runs unit tests of the core under Miri, which sees undefined behaviour of it and of the crates below it.
#
#   miri.sh --quick    short tests, 32-bit pointers
#   miri.sh            those on 32-bit, 64-bit and big-endian targets, then every test that is not named as long
#
# Miri runs some thousand times slower than the processor. x86-64 cannot be had: libm takes its square root there by inline
# assembly. Installs what is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
exec </dev/null

quick=${1-}
[[ -z $quick || $quick == --quick ]] || { echo 'usage: miri.sh [--quick]' >&2; exit 2; }
root=$(cd ../.. && pwd)
"$root/.ci/install" rustup:nightly:miri rustup:nightly:rust-src
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}/miri
# A sine is the same each time it is computed, as on a machine: tests compute the expected value a second time.
export MIRIFLAGS="${MIRIFLAGS:-} -Zmiri-strict-provenance -Zmiri-deterministic-floats -Zmiri-disable-isolation"
# Tests leak what loops borrow.
MIRIFLAGS+=" -Zmiri-ignore-leaks"
export PROPTEST_CASES=2

# Parsers of what comes from outside, exchange, index arithmetic, states: all that handles bytes and indices.
short=(
    contour::buffer
    learned::tests::another_program_length
    learned::tests::every_damage_is_refused
    learned::tests::figures_out_of_range
    learned::tests::nodes_come_back
    learned::tests::the_id_of_a_program
    check::tests::a_rotary_axis_turns
    check::tests::chains_with
    check::tests::look_ups_of_the_inverse
    check::tests::tables_that_break_a_rule
    compensation::tests::backlash_and_reverse
    limiter::tests::freezing_brakes
    roundness::counter
)
# Millions of cycles, searches over whole ranges: minutes to hours each under Miri.
long=(
    roundness::transform::index_maps roundness::counter::tests::every_count roundness::resample roundness::tests
    check::open_loop check::volumetric check::tests::lost_motion check::tests::the_look_ups check::tests::the_norm
    check::tests::the_range compensation::trig compensation::volumetric compensation::tests::a_drive_that_goes_on
    compensation::grid::tests::a_look_up_is compensation::grid::tests::bounds_hold compensation::grid::tests::boxes_say
    compensation::grid::tests::the_inverse compensation::tests::cubic_tables_pass compensation::tests::linear_tables_agree
    compensation::tests::pieces roundness::angles::tests::known_arrangements roundness::transform::tests::all_lengths
    compensation::tests::single_precision compensation::tests::the_exact_inverse temperature::tests::a_stuck
    contour::command_window contour::tests contour::pair contour::orientation contour::nearest contour::convert
    kinematics limiter::tests::limits_lowered limiter::tests::never_exceeds limiter::tests::the_shortcuts
    limiter::tests::the_time limiter::tests::passes_what learned::tests::beyond_the_ends machine sample step vector
)
run() { # seconds, target, filters of libtest
    local seconds=$1 target=$2
    shift 2
    timeout "$seconds" cargo +nightly miri test --quiet -p trueaxis --lib --target "$target" -- "$@"
}
skip=()
for name in roundness::counter::tests::every_count; do skip+=(--skip "$name"); done
run 2700 armv7-unknown-linux-gnueabihf "${short[@]}" "${skip[@]}"
[[ -z $quick ]] || exit 0
run 2700 riscv64gc-unknown-linux-gnu "${short[@]}" "${skip[@]}"
# Big-endian.
run 2700 s390x-unknown-linux-gnu "${short[@]}" "${skip[@]}"
skip=()
for name in "${long[@]}"; do skip+=(--skip "$name"); done
run 3600 armv7-unknown-linux-gnueabihf "${skip[@]}"
