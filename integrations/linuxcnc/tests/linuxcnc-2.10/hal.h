/* What the component asks of the hal.h of LinuxCNC 2.10, which no distribution has yet: the same names, types and values,
 * written from its declarations (src/hal/hal.h of LinuxCNC's main branch, pull requests 4099 and 4472). What 2.10 deprecates
 * is left out, so that whoever uses it does not compile. rtapi.h and rtapi_app.h are those of 2.9; what is asked of them is
 * the same on both. The calls behind it are in ../sanitize/double.c.
 *
 * License: MIT OR Apache-2.0
 */
#ifndef TRUEAXIS_DOUBLE_OF_HAL_H
#define TRUEAXIS_DOUBLE_OF_HAL_H

#include <stdbool.h>
#include <stdint.h>

#include "rtapi.h"

#define HAL_NAME_LEN 55

typedef enum { HAL_BIT = 1, HAL_FLOAT = 2, HAL_S32 = 3, HAL_U32 = 4 } hal_type_t;
/* One type for pins and parameters. */
typedef enum { HAL_IN = 16, HAL_OUT = 32, HAL_IO = 48, HAL_RO = 64, HAL_RW = 192 } hal_pdir_t;

/* The place of any value is eight bytes, little end first; a truth and 32 bits are its lowest. */
typedef union {
    volatile bool b;
    volatile int32_t s;
    volatile uint32_t u;
    volatile double f;
    volatile int64_t ls;
    volatile uint64_t lu;
} hal_data_u;

/* Handles can be copied, and neither followed nor mistaken for each other. */
typedef struct double_of_bool *hal_bool_t;
typedef struct double_of_sint *hal_sint_t;
typedef struct double_of_uint *hal_uint_t;
typedef struct double_of_real *hal_real_t;

#define HAL_KIND(kind, handle, value, get, set)                                                                         \
    static inline value hal_get_##kind(const handle ref)                                                                \
    {                                                                                                                   \
        return ((hal_data_u *)ref)->get;                                                                                \
    }                                                                                                                   \
    static inline value hal_set_##kind(handle ref, value to)                                                            \
    {                                                                                                                   \
        ((hal_data_u *)ref)->set = to;                                                                                  \
        return to;                                                                                                      \
    }                                                                                                                   \
    int hal_pin_new_##kind(int component, hal_pdir_t way, handle *ref, value first, const char *format, ...)            \
        __attribute__((format(printf, 5, 6)));                                                                          \
    int hal_param_new_##kind(int component, hal_pdir_t way, handle *ref, value first, const char *format, ...)          \
        __attribute__((format(printf, 5, 6)));
HAL_KIND(bool, hal_bool_t, bool, b, lu)
HAL_KIND(si32, hal_sint_t, int32_t, s, ls)
HAL_KIND(ui32, hal_uint_t, uint32_t, u, lu)
HAL_KIND(real, hal_real_t, double, f, f)
#undef HAL_KIND

extern int hal_init(const char *name);
extern int hal_exit(int component);
extern int hal_ready(int component);
extern void *hal_malloc(long int size);
extern int hal_export_funct(const char *name, void (*call)(void *, long), void *argument, int floats, int reentrant, int component);

#endif
