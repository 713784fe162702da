# Compiler flags for a core, the same for the images and the counts, which share the built crates: `flags CORE`, and the
# folder: `built CORE`. Each core has its own: where a flag renames paths, cargo does not tell apart what the others change.
# Needs $repository and $target.

# Names of source files are among the constants: folders are removed from them, so that the size is the same everywhere.
plain=
if [[ $repository$HOME${CARGO_HOME-} != *[[:space:]]* ]]; then
    plain="--remap-path-prefix=$repository=. --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
fi
export RUSTC_WRAPPER=$repository/firmware-sim/cortex-m/rustc.sh
flags() {
    case $1 in
    m4f) echo "$plain" ;;
    m7) echo "-Ctarget-cpu=cortex-m7 $plain" ;;
    esac
}
built() { # that of the M4F is also that of clippy and of the proofs, which need the same of the host
    case $1 in
    m4f) echo "$target" ;;
    m7) echo "$target/m7" ;;
    esac
}
