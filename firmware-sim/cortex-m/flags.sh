# Compiler flags for a core, the same for images, counts and proofs, which share the built crates: `flags CORE`.
# Needs $repository.

# Names of source files are among the constants: folders are removed from them, so that the size is the same everywhere.
plain=
if [[ $repository$HOME${CARGO_HOME-} != *[[:space:]]* ]]; then
    plain="--remap-path-prefix=$repository=. --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
fi
flags() {
    case $1 in
    m4f) echo "$plain" ;;
    m7) echo "-Ctarget-cpu=cortex-m7 $plain" ;;
    esac
}
