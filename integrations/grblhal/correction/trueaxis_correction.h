/*
 * Corrects positions by the tables of a machine, for hosts that correct in the planner: stateless, in the host's single
 * precision, on top of the C library. Independent of any host.
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
/* Memory for the tables' nodes; `trueaxis tables show` prints the memory that a machine needs. */
#ifdef TRUEAXIS_SINGLE
#define TRUEAXIS_MEMORY_BYTES 24576
#else
#define TRUEAXIS_MEMORY_BYTES 49152
#endif
#endif

/* Reads the .tcomp in place and builds the tables in memory of this module. `machine_id`: 0 accepts any machine.
 * `axes`: number of axes of the controller, in the order X Y Z A B C. Returns NULL, or one line with the reason why the
 * file is refused. Do not call it while the machine moves. Takes 26 kB of stack (33 kB in double precision) and about ten
 * thousand lookups, to find the largest correction. */
const char *trueaxis_correction_load(const uint8_t *file, size_t length, uint32_t machine_id, unsigned axes);

/* The loaded tables. */
const trueaxis_tables_info_t *trueaxis_correction_tables(void);

/* Index, in the controller's order, of the axis with index `slot` in the tables' order. */
unsigned trueaxis_correction_axis(unsigned slot);

/* Bits of the controller's axes that the tables include. */
uint8_t trueaxis_correction_axes(void);

/* Largest correction of an axis, mm, found by a search over the tables' travel, plus 1 um for what the search may
 * miss. */
float trueaxis_correction_largest(unsigned slot);

/* Position of the drives for the tool at p: q = p + c(p), in mm or, for rotary axes, degrees. `negative`: bit 0 = X, ...:
 * whether the axis last moved in its negative direction. Outside the tables' travel the correction at the edge applies,
 * limited to `correction_limit`. Axes without tables pass unchanged. `drive` may be `command`. */
void trueaxis_correction_forward(const float *command, uint8_t negative, float *drive);

/* Finds p for q by repeating p = q - c(p) until it converges to 1 nm, at most 8 times. The slope of a correction is below
 * 1e-2, so every pass adds two digits. `command` may be `drive`. */
void trueaxis_correction_inverse(const float *drive, uint8_t negative, float *command);

#endif
