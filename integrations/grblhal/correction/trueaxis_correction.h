/*
 * Correction of positions by the tables of a machine, for hosts that correct in the planner: stateless, in the host's
 * single precision, based on the C library. Independent of any host.
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
 * file is refused. Do not call it while the machine moves; 31 kB of stack, 39 kB in double precision. It finds the
 * largest correction with about ten thousand look-ups. */
const char *trueaxis_correction_load(const uint8_t *file, size_t length, uint32_t machine_id, unsigned axes);

/* The loaded tables. */
const trueaxis_tables_info_t *trueaxis_correction_tables(void);

/* Index, in the controller's order, of the axis with index `slot` in the tables' order. */
unsigned trueaxis_correction_axis(unsigned slot);

/* Bits of the controller's axes that the tables include. */
uint8_t trueaxis_correction_axes(void);

/* The largest correction of that axis, found by a search over the tables' travel, mm, plus 1 um that the search may
 * miss. */
float trueaxis_correction_largest(unsigned slot);

/* q = p + c(p): position of the drives for the tool at p. mm; degrees for rotary axes. `negative`: bit 0 = X, ...: the
 * axis last moved in its negative direction. Outside the tables' travel the correction at the edge applies; it is
 * limited to `correction_limit`. Axes without tables pass. `drive` may be `command`. */
void trueaxis_correction_forward(const float *command, uint8_t negative, float *drive);

/* p from q, by repeating p = q - c(p) until it converges to 1 nm, at most 8 times. The slope of a correction is below
 * 1e-2, so every pass adds two digits. `command` may be `drive`. */
void trueaxis_correction_inverse(const float *drive, uint8_t negative, float *command);

#endif
