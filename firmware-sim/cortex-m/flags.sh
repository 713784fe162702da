# Flags of the compiler for a core, the same for the images and the counts, which share what they build: `flags CORE`.
# Needs $repository.

# Names of source files are among the constants: without the folders before them, so that the size is the same everywhere.
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
