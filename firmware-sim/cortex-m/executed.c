/* Plugin for QEMU: addresses of the instructions that the last call of a function executed.

   -plugin libexecuted.so,from=ADDRESS[,from=ADDRESS...],out=FILE. Whenever the instruction at a `from` is reached, what was
   noted before is forgotten; at the end all that came since is written, an address a line. The interface is declared here, because
   Debian's package has no header: version 1, QEMU 4.2 to 8. */

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
struct qemu_info;
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS, QEMU_PLUGIN_CB_R_REGS, QEMU_PLUGIN_CB_RW_REGS };
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, struct qemu_plugin_tb *));
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, void *), void *);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *, void (*)(unsigned int, void *),
                                            enum qemu_plugin_cb_flags, void *);

#define EXPORT __attribute__((visibility("default")))
EXPORT int qemu_plugin_version = 1;

/* More than any cycle takes; what comes after is not kept. */
#define MOST (1 << 20)

static uint32_t noted[MOST];
static size_t count;
static int started;
static uint32_t from[8];
static size_t froms;
static char out[4096];

static void executed(unsigned int cpu, void *address) {
    uint32_t at = (uint32_t)(uintptr_t)address;
    (void)cpu;
    for (size_t i = 0; i < froms; i++)
        if (at == from[i]) {
            started = 1;
            count = 0;
        }
    if (started && count < MOST)
        noted[count++] = at;
}

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb *block) {
    (void)id;
    for (size_t i = 0; i < qemu_plugin_tb_n_insns(block); i++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(block, i);
        void *address = (void *)(uintptr_t)qemu_plugin_insn_vaddr(insn);
        qemu_plugin_register_vcpu_insn_exec_cb(insn, executed, QEMU_PLUGIN_CB_NO_REGS, address);
    }
}

static void ended(qemu_plugin_id_t id, void *nothing) {
    FILE *file = fopen(out, "w");
    (void)id;
    (void)nothing;
    if (!file) {
        perror(out);
        exit(1);
    }
    for (size_t i = 0; i < count; i++)
        fprintf(file, "%x\n", noted[i]);
    fclose(file);
}

EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const struct qemu_info *info, int argc, char **argv) {
    (void)info;
    for (int i = 0; i < argc; i++) {
        if (strncmp(argv[i], "from=", 5) == 0 && froms < sizeof from / sizeof *from)
            from[froms++] = strtoul(argv[i] + 5, NULL, 0) & ~1u;
        else if (strncmp(argv[i], "out=", 4) == 0)
            snprintf(out, sizeof out, "%s", argv[i] + 4);
    }
    if (!froms || !out[0]) {
        fprintf(stderr, "executed: needed from=ADDRESS,out=FILE\n");
        return -1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ended, NULL);
    return 0;
}
