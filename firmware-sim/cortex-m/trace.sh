# `trace CORE KIND NUMBER FILE`: the addresses that a cycle of the counts executes in the bare step, by a plugin of QEMU, and
# what the program prints in FILE.log. KIND is 1 for a cycle of the recording, 2 for an adversarial one. After count.sh.
#
# Needs $target.
mkdir -p "$target/cycles"
cc -O2 -shared -fPIC -o "$target/cycles/executed.so" executed.c

elf() {
    echo "$target/count/$1.elf"
}
trace() {
    local core=$1 kind=$2 number=$3 to=$4 board file place options
    case $core in
        m4f) board=(-M mps2-an386 -cpu cortex-m4) ;;
        m7) board=(-M mps2-an500 -cpu cortex-m7) ;;
    esac
    options=(-device "loader,addr=0x003ffff8,data=$kind,data-len=4" -device "loader,addr=0x003ffffc,data=$number,data-len=4")
    for file in a.tcomp=0x00110000 b.tcomp=0x00140000 run.rec=0x00180000; do
        options+=(-device "loader,file=${target//,/,,}/count/${file%=*},addr=${file#*=},force-raw=on")
    done
    # The bare step, in each scalar that the image has.
    local plugin=$target/cycles/executed.so,out=$to
    for place in $(llvm-nm --demangle "$(elf "$core")" | awk '$3 ~ /^count::forms::bare/ { print $1 }'); do
        plugin+=,from=0x$place
    done
    timeout 600 qemu-system-arm "${board[@]}" -nographic -monitor none -serial none -icount shift=7,align=off,sleep=off \
        -semihosting-config enable=on,target=native "${options[@]}" -plugin "$plugin" -kernel "$(elf "$core")" >"$to.log"
}
# A figure of the counts: core, scalar, line, name.
counted() {
    awk -v s="$2" -v n="$3" -v k="$4" '$1 == s && $2 == n { for (i = 3; i < NF; i++) if ($i == k) print $(i + 1) }' "$target/$1.txt"
}
