/* The part of LinuxCNC 2.10's hal.h that the component uses; no distribution has it yet. It has the same names, types
 * and values, written from the declarations in src/hal/hal.h of LinuxCNC's main branch (pull requests 4099 and 4472).
 * Everything that 2.10 deprecates is omitted, so that its use does not compile. rtapi.h and rtapi_app.h are those of
 * 2.9; the parts of them that are used are the same on both. The functions are implemented in ../sanitize/double.c.
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

/* Every value is stored in eight bytes, little-endian; a bool and 32-bit values use the lowest bytes. */
typedef union {
    volatile bool b;
    volatile int32_t s;
    volatile uint32_t u;
    volatile double f;
    volatile int64_t ls;
    volatile uint64_t lu;
} hal_data_u;

/* Handles can be copied, but not dereferenced or confused with each other. */
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
