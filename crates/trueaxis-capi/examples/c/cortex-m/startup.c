/* Startup code of a Cortex-M4F or M7 before main: vectors, floating point, memory, semihosting. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t stack_top, data_start, data_end, data_load, bss_start, bss_end;

int main(void);
void initialise_monitor_handles(void);
void reset(void);

/* newlib calls these before and after main; nothing needs constructing. */
void _init(void);
void _fini(void);
void _init(void) {}
void _fini(void) {}

static void stop(void) {
    _Exit(3);
}

/* The floating point unit (CP10, CP11) must be on before the first instruction of a function that saves its registers. */
__attribute__((naked, noreturn)) void reset(void) {
    __asm volatile("ldr r0, =0xE000ED88\n"
                   "ldr r1, [r0]\n"
                   "orr r1, r1, #(0xF << 20)\n"
                   "str r1, [r0]\n"
                   "dsb\n"
                   "isb\n"
                   "b start\n");
}

__attribute__((noreturn, used)) static void start(void) {
    for (uint32_t *to = &data_start, *from = &data_load; to < &data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = &bss_start; to < &bss_end;) {
        *to++ = 0;
    }
    initialise_monitor_handles();
    exit(main());
}

typedef void handler(void);

/* Handlers from NMI to SysTick; nothing here uses interrupts. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    handler *handlers[15];
} vectors = { &stack_top,
              { reset, stop, stop, stop, stop, stop, NULL, NULL, NULL, NULL, stop, stop, NULL, stop, stop } };
