/*
 * Correction of positions by the tables of a machine, for hosts that correct in the planner: stateless, in the host's
 * single precision, on the C library. Knows no host.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */
#ifndef TRUEAXIS_CORRECTION_H
#define TRUEAXIS_CORRECTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "trueaxis.h"

#ifndef TRUEAXIS_MEMORY_BYTES
/* For the tables' nodes; `trueaxis tables show` prints the memory that a machine needs. */
#ifdef TRUEAXIS_SINGLE
#define TRUEAXIS_MEMORY_BYTES 24576
#else
#define TRUEAXIS_MEMORY_BYTES 49152
#endif
#endif

/* Reads the .tcomp where it lies and builds the tables into memory of this module. `machine_id`: 0 takes any machine.
 * `axes`: of the controller, in the order X Y Z A B C. Returns NULL, or one line that says why the file is refused. Not
 * while the machine moves; 31 kB of stack, 39 kB in double precision. Some ten thousand look-ups find the largest
 * correction. */
const char *trueaxis_correction_load(const uint8_t *file, size_t length, uint32_t machine_id, unsigned axes);

/* The tables loaded. */
const trueaxis_tables_info_t *trueaxis_correction_tables(void);

/* Number, in the controller's order, of the axis that is `slot` in the tables' order. */
unsigned trueaxis_correction_axis(unsigned slot);

/* Bits of the controller's axes that the tables speak of. */
uint8_t trueaxis_correction_axes(void);

/* The largest correction of that axis found by a search of the tables' travel, mm, plus 1 um that it may miss. */
float trueaxis_correction_largest(unsigned slot);

/* q = p + c(p): position of the drives for the tool at p. mm, rotary axes degrees. `negative`: bit 0 = X, ...:
 * the axis last moved in its negative direction. Outside the tables' travel the correction of its edge holds; above
 * `correction_limit` it is clamped. Axes without tables pass. `drive` may be `command`. */
void trueaxis_correction_forward(const float *command, uint8_t negative, float *drive);

/* p from q, by repeating p = q - c(p) until it converges to 1 nm, at most 8 times. The slope of a correction is below 1e-2,
 * so every pass brings two digits. `command` may be `drive`. */
void trueaxis_correction_inverse(const float *drive, uint8_t negative, float *command);

#endif
