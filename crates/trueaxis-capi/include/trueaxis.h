/*
 * trueaxis: geometric error compensation and true contour error inside the servo step of an open CNC controller.
 *
 * Generated from the Rust source; do not edit. C99, usable from C++.
 *
 * Rules for all functions
 *   - The answer is a trueaxis_status_t: 0 (TRUEAXIS_OK) or a TRUEAXIS_ERROR_..., never negative. When a function
 *     refuses, everything that it would have written stays as it was (but trueaxis_error_t, which then says why).
 *   - No function panics, allocates, prints, locks or calls the operating system.
 *   - Objects (trueaxis_loop_t, trueaxis_state_t, ...) are storage of fixed size that the caller provides, best zeroed
 *     before; they hold no resources, so there is nothing to free. Memory that is lent to an object must outlive it.
 *   - Structures that begin with a member `size` want it set by the caller once: `input.size = sizeof input;`.
 *   - Pointers must be NULL or point to what their type says; NULL is refused unless the function allows it. Memory must
 *     not overlap between arguments.
 *   - Two threads may use the same loop, path and gauge at the same time (they are only read), never the same state.
 *   - "Real-time safe" functions run in bounded time and may be called in the servo interrupt; the others belong to the
 *     start of the program or to a background task. All of them are reentrant.
 *
 * Units: mm, for rotary axes degrees; time ns; signs as in ISO 841 and ISO 230-1 (error = actual - ideal).
 *
 * Precision: a library for cores without double precision is built with `--features single`; define TRUEAXIS_SINGLE
 * before including this header then, and only then.
 */

#ifndef TRUEAXIS_H
#define TRUEAXIS_H

#include <stddef.h>
#include <stdint.h>

/* Version of this header: check it against the library's with trueaxis_check_abi(TRUEAXIS_ABI_VERSION). */
#ifndef TRUEAXIS_ABI_MAJOR
#define TRUEAXIS_ABI_MAJOR 1
#endif
#ifndef TRUEAXIS_ABI_MINOR
#define TRUEAXIS_ABI_MINOR 0
#endif
#ifdef TRUEAXIS_SINGLE
#define TRUEAXIS_ABI_VERSION (UINT32_C(0x80000000) | (uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#else
#define TRUEAXIS_ABI_VERSION ((uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#endif

/**
 * Words of a `trueaxis_path_t`.
 */
#define TRUEAXIS_PATH_WORDS 8

/**
 * Words of a `trueaxis_loop_t`.
 */
#define TRUEAXIS_LOOP_WORDS 640

/**
 * Words of a `trueaxis_state_t`.
 */
#define TRUEAXIS_STATE_WORDS 160

/**
 * Most axes of a machine.
 */
#define TRUEAXIS_AXES_MAX 6

/**
 * The foot is a minimum of the distance, bracketed by − and +.
 */
#define TRUEAXIS_CONTOUR_BRACKETED 1

/**
 * The foot is an end of an open path.
 */
#define TRUEAXIS_CONTOUR_AT_END 2

/**
 * The foot is a corner between two pieces.
 */
#define TRUEAXIS_CONTOUR_AT_CORNER 4

/**
 * A second minimum may be near.
 */
#define TRUEAXIS_CONTOUR_SECOND_MINIMUM 8

/**
 * No foot was known from the last cycle; the way around the reference is being looked over.
 */
#define TRUEAXIS_CONTOUR_COLD 16

/**
 * No path, or no belief in the readings: nothing was measured, all other members are 0.
 */
#define TRUEAXIS_CONTOUR_NOT_FOUND 32

/**
 * Bit of `status`: homed, enabled and believed, corrections are followed.
 */
#define TRUEAXIS_STATUS_ACTIVE 1

/**
 * Bit of `status`: the correction is frozen because a reading is not believed.
 */
#define TRUEAXIS_STATUS_FROZEN 2

/**
 * Bit of `status`: the output is held and the host must stop the machine.
 */
#define TRUEAXIS_STATUS_STOP_REQUEST 4

/**
 * Bit of `status`: the contour error of this cycle was measured.
 */
#define TRUEAXIS_STATUS_CONTOUR 8

/**
 * Nothing is wrong.
 */
#define TRUEAXIS_FAULT_NONE 0

/**
 * An encoder gave no finite reading. From here to 15: the correction freezes and the command passes.
 */
#define TRUEAXIS_FAULT_FEEDBACK_NOT_FINITE 1

/**
 * A reading changed more in a cycle than the axis can move.
 */
#define TRUEAXIS_FAULT_FEEDBACK_JUMP 2

/**
 * A reading stands still though the axis was commanded to move.
 */
#define TRUEAXIS_FAULT_ENCODER_STUCK 3

/**
 * The encoder interface reports an alarm (dropout).
 */
#define TRUEAXIS_FAULT_ENCODER_ALARM 4

/**
 * The cycle came late: its period is off by more than a quarter.
 */
#define TRUEAXIS_FAULT_LATE_CYCLE 5

/**
 * A command is infinite or not a number. From here to 31: the output holds and a stop is requested.
 */
#define TRUEAXIS_FAULT_COMMAND_NOT_FINITE 16

/**
 * A command lies outside the declared travel.
 */
#define TRUEAXIS_FAULT_COMMAND_OUT_OF_TRAVEL 17

/**
 * A command changed more in a cycle than the axis can move.
 */
#define TRUEAXIS_FAULT_COMMAND_JUMP 18

/**
 * Command plus correction leaves the range of the joint.
 */
#define TRUEAXIS_FAULT_JOINT_RANGE 19

/**
 * No pose of the machine brings the tool to the commanded tip and direction.
 */
#define TRUEAXIS_FAULT_TOOL_UNREACHABLE 20

/**
 * The commanded direction is too near to the singular one.
 */
#define TRUEAXIS_FAULT_SINGULAR_POSE 21

/**
 * The commanded direction asks the rotary axes to go over to their other solution faster than they can.
 */
#define TRUEAXIS_FAULT_BRANCH_CHANGE 22

/**
 * The host's servo period is not the configured one. From here on: refused at start, the command passes uncorrected
 * (`trueaxis_loop_bypass`).
 */
#define TRUEAXIS_FAULT_PERIOD_MISMATCH 32

/**
 * The table file is damaged, or of another format, version or machine.
 */
#define TRUEAXIS_FAULT_TABLES_REFUSED 33

/**
 * The tables need more memory than there is.
 */
#define TRUEAXIS_FAULT_CAPACITY_TOO_SMALL 34

/**
 * Host and library were built for different versions of the interface.
 */
#define TRUEAXIS_FAULT_ABI_MISMATCH 35

/**
 * A buffer of this size holds the frame of any record.
 */
#define TRUEAXIS_FRAME_BYTES 256

/**
 * Answer of a function: `TRUEAXIS_OK` or one of `TRUEAXIS_ERROR_…`, never negative. `trueaxis_status_text` has words
 * for each.
 */
typedef int32_t trueaxis_status_t;

/**
 * Contents of a table file. The first `axes` places of the arrays count, in the order of the step; travel and limits of
 * a linear axis that the machine does not have are 0: it is passed as commanded.
 */
typedef struct trueaxis_tables_info_t {
    /**
     * `sizeof(trueaxis_tables_info_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * Number of axes of the step, 3 to 6.
     */
    uint32_t axes;
    /**
     * Letters of the axes, closed by a zero: X, Y, Z (always; a missing one has no table), then the rotary axes in
     * alphabetical order.
     */
    char letters[8];
    /**
     * Identity of the machine: CRC-32 of its name and chain.
     */
    uint32_t machine_id;
    /**
     * CRC-32 at the end of the file: the version of these tables.
     */
    uint32_t tables_crc;
    /**
     * Look-ups that the exact inverse takes in a cycle.
     */
    uint32_t inverse_passes;
    /**
     * Points of a revolution of the machine's gauge, 0 without a gauge.
     */
    uint32_t gauge_points;
    /**
     * Bytes of memory that `trueaxis_loop_build` needs beside `trueaxis_loop_t`.
     */
    uint64_t memory_bytes;
    /**
     * Lines of the axis' error table, 0 without one.
     */
    uint32_t rows[TRUEAXIS_AXES_MAX];
    /**
     * Declared travel, low end, mm (deg). A command outside is a fault.
     */
    double travel_low[TRUEAXIS_AXES_MAX];
    /**
     * Declared travel, high end, mm (deg).
     */
    double travel_high[TRUEAXIS_AXES_MAX];
    /**
     * Largest |correction|, mm (deg).
     */
    double correction_limit[TRUEAXIS_AXES_MAX];
    /**
     * Largest |rate of change of the correction|, mm/s (deg/s).
     */
    double slope_limit_per_s[TRUEAXIS_AXES_MAX];
    /**
     * Largest |acceleration of the correction|, mm/s² (deg/s²).
     */
    double acceleration_limit_per_s2[TRUEAXIS_AXES_MAX];
    /**
     * Name of the machine, UTF-8, closed by a zero.
     */
    char name[72];
    /**
     * Structural code of the machine (ISO 10791-6), closed by a zero.
     */
    char chain[56];
} trueaxis_tables_info_t;

/**
 * Why something was refused, ready to print.
 */
typedef struct trueaxis_error_t {
    /**
     * `sizeof(trueaxis_error_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * The status that the function returned.
     */
    trueaxis_status_t status;
    /**
     * Number of the table file's fault: 1 too short, 2 too long, 3 not a `.tcomp`, 4 other format version, 5 CRC-32
     * wrong, 6 settings and 7 table header cannot be decoded, 8 table or 9 payload too long, 10 machine id contradicts
     * the name, 11 contents make no sense (then `field`, `found` and `needed` tell which), 12 other machine. 0: not about
     * a table file.
     */
    uint32_t code;
    /**
     * Element of the setting that is wrong, from 0 (row of a table); `UINT32_MAX` if it is no list.
     */
    uint32_t index;
    /**
     * What was found, in mm, degrees or seconds.
     */
    double found;
    /**
     * Letter of the axis at fault, 0 if it is none's.
     */
    char axis;
    /**
     * Name of the setting at fault; empty if it is none's.
     */
    char field[31];
    /**
     * What is needed instead; empty if nothing can be said.
     */
    char needed[128];
    /**
     * All of it in one line of UTF-8 without a line feed.
     */
    char text[256];
} trueaxis_error_t;

/**
 * The immutable half: tables, limits and settings of a machine, built once. May be copied and read from any thread.
 */
typedef struct trueaxis_loop_t {
    uint64_t words[TRUEAXIS_LOOP_WORDS];
} trueaxis_loop_t;

/**
 * The mutable half: what one cycle hands to the next. Belongs to the thread that steps it.
 */
typedef struct trueaxis_state_t {
    uint64_t words[TRUEAXIS_STATE_WORDS];
} trueaxis_state_t;

#if !defined(TRUEAXIS_SINGLE)
/**
 * Position of an axis: mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` 32-bit integers of 1e-6 mm = 1 nm
 * (1e-6 degrees).
 */
typedef double trueaxis_position_t;
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Position of an axis: mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` 32-bit integers of 1e-6 mm = 1 nm
 * (1e-6 degrees).
 */
typedef int32_t trueaxis_position_t;
#endif

/**
 * What the host hands over in a servo cycle. Axes stand in the order of `trueaxis_tables_info_t.letters`: X, Y, Z, then
 * the rotary axes of the machine in alphabetical order; places beyond the machine's axes are not looked at.
 */
typedef struct trueaxis_input_t {
    /**
     * `sizeof(trueaxis_input_t)`, set by the caller.
     */
    uint32_t size;
    /**
     * Time since the last cycle as the host measured or knows it, ns. Off by more than a quarter of the period, the
     * correction freezes for this cycle (`TRUEAXIS_FAULT_LATE_CYCLE`).
     */
    uint32_t elapsed_ns;
    /**
     * Commanded positions, uncorrected.
     */
    trueaxis_position_t command[TRUEAXIS_AXES_MAX];
    /**
     * Raw encoder positions. A reading that is not a number, or beyond 1e9, is a dropout.
     */
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /**
     * A bit for every axis whose encoder interface reports an alarm, bit 0 = X.
     */
    uint8_t encoder_alarm;
    /**
     * Not 0: all axes are homed, positions are machine positions.
     */
    uint8_t homed;
    /**
     * Not 0: compensation is wanted.
     */
    uint8_t enable;
    /**
     * Not 0: releases a latched stop request (on its rising edge, near the held position).
     */
    uint8_t reset;
} trueaxis_input_t;

/**
 * A programmed path: lines, arcs and splines, converted into pieces in memory that the caller lends.
 */
typedef struct trueaxis_path_t {
    uint64_t words[TRUEAXIS_PATH_WORDS];
} trueaxis_path_t;

#if !defined(TRUEAXIS_SINGLE)
/**
 * Scalar of the arithmetic: `double`, with `TRUEAXIS_SINGLE` `float`.
 */
typedef double trueaxis_real_t;
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Scalar of the arithmetic: `double`, with `TRUEAXIS_SINGLE` `float`.
 */
typedef float trueaxis_real_t;
#endif

/**
 * A place on a path: a piece of it, and where in the piece. `trueaxis_path_reference` makes it from a segment and its
 * parameter.
 */
typedef struct trueaxis_reference_t {
    /**
     * Sequence number of the piece.
     */
    uint32_t span;
    /**
     * Parameter in the piece, 0 to 1.
     */
    trueaxis_real_t t;
} trueaxis_reference_t;

/**
 * Contour error in a cycle; lengths in mm.
 */
typedef struct trueaxis_contour_t {
    /**
     * Piece of the path on which the foot lies.
     */
    uint32_t span;
    /**
     * Evaluations of the path that the search took.
     */
    uint8_t evaluations;
    /**
     * `TRUEAXIS_CONTOUR_…` bits: how the foot was found.
     */
    uint8_t flags;
    /**
     * 0.
     */
    uint16_t reserved;
    /**
     * Parameter of the foot in the piece, 0 to 1.
     */
    trueaxis_real_t t;
    /**
     * Distance from the path: |actual − foot|, never negative.
     */
    trueaxis_real_t error;
    /**
     * Actual − foot along X, Y, Z.
     */
    trueaxis_real_t vector[3];
    /**
     * Component in the machining plane, positive to the left of the path.
     */
    trueaxis_real_t normal;
    /**
     * Component along the plane's normal.
     */
    trueaxis_real_t binormal;
    /**
     * Component along the path: 0 but at ends and corners.
     */
    trueaxis_real_t tangential;
    /**
     * Arc length from the foot to the reference, positive while the tool lags.
     */
    trueaxis_real_t lag;
    /**
     * What is left of the bracket around the foot, arc length.
     */
    trueaxis_real_t width;
} trueaxis_contour_t;

/**
 * The telemetry of a cycle. Positions in `trueaxis_position_t`, everything else in mm (rotary: degrees).
 */
typedef struct trueaxis_record_t {
    /**
     * Counts cycles from 0, wrapping.
     */
    uint32_t sequence;
    /**
     * Identity of the machine that the tables belong to; 0 in a bypass.
     */
    uint32_t machine_id;
    /**
     * CRC-32 of the table file in force; 0 in a bypass.
     */
    uint32_t tables_crc;
    /**
     * `TRUEAXIS_FAULT_…`: what went wrong, 0 if nothing.
     */
    uint8_t fault;
    /**
     * Place of the axis that the fault belongs to.
     */
    uint8_t fault_axis;
    /**
     * `TRUEAXIS_STATUS_…` bits.
     */
    uint8_t status;
    /**
     * A bit for every axis whose correction differs from the wanted one.
     */
    uint8_t limited;
    /**
     * A bit for every axis whose table holds its edge value.
     */
    uint8_t at_edge;
    /**
     * `TRUEAXIS_CONTOUR_…` bits of the orientation error: not found in all steps of this interface.
     */
    uint8_t orientation_flags;
    /**
     * 0.
     */
    uint16_t reserved;
    /**
     * Command as it came (the held one during a stop).
     */
    trueaxis_position_t command[TRUEAXIS_AXES_MAX];
    /**
     * Raw feedback (last good one during a fault).
     */
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /**
     * Correction sent: `drive − command` before rounding to a position.
     */
    trueaxis_real_t correction[TRUEAXIS_AXES_MAX];
    /**
     * Contour error of the estimated tool tip.
     */
    struct trueaxis_contour_t tip;
    /**
     * Contour error of the plain encoder position.
     */
    struct trueaxis_contour_t encoder;
    /**
     * Orientation contour error, rad: 0 in all steps of this interface.
     */
    trueaxis_real_t orientation;
} trueaxis_record_t;

/**
 * What a servo cycle gives back.
 */
typedef struct trueaxis_output_t {
    /**
     * `sizeof(trueaxis_output_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * Number of axes that count in the arrays.
     */
    uint32_t axes;
    /**
     * Corrected positions for the drives.
     */
    trueaxis_position_t drive[TRUEAXIS_AXES_MAX];
    /**
     * Feedback for the host, without the correction: it sees no following error that is not there.
     */
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /**
     * The cycle's telemetry.
     */
    struct trueaxis_record_t record;
} trueaxis_output_t;

/**
 * Done.
 */
#define TRUEAXIS_OK 0

/**
 * A pointer that must be given is `NULL`.
 */
#define TRUEAXIS_ERROR_NULL 1

/**
 * A structure or buffer has another size than this library needs: check `size` members and size arguments, that the
 * header belongs to the library, and that `TRUEAXIS_SINGLE` is defined for a single-precision library and for no other.
 */
#define TRUEAXIS_ERROR_SIZE 2

/**
 * A pointer is not aligned as its type needs; memory for tables and paths: 8 bytes.
 */
#define TRUEAXIS_ERROR_ALIGNMENT 3

/**
 * An object was never built or started, or is of another kind.
 */
#define TRUEAXIS_ERROR_UNBUILT 4

/**
 * Header and library are of different versions or of different precision.
 */
#define TRUEAXIS_ERROR_ABI 5

/**
 * The bytes are not a whole, undamaged `.tcomp` file of this format; details in `trueaxis_error_t`.
 */
#define TRUEAXIS_ERROR_TABLES 6

/**
 * The file is made for another machine.
 */
#define TRUEAXIS_ERROR_MACHINE 7

/**
 * What the file describes cannot be run with this configuration; details in `trueaxis_error_t`.
 */
#define TRUEAXIS_ERROR_CONFIG 8

/**
 * The memory lent is smaller than needed (`trueaxis_tables_info_t.memory_bytes`).
 */
#define TRUEAXIS_ERROR_MEMORY 9

/**
 * The period is not the one that the loop was built for (within 0.1 %).
 */
#define TRUEAXIS_ERROR_PERIOD 10

/**
 * Loop and state have different numbers of axes, or the number is not 3 to 6.
 */
#define TRUEAXIS_ERROR_AXES 11

/**
 * The state was started by a loop of the other kind (bypass or not): start a new one.
 */
#define TRUEAXIS_ERROR_STATE 12

/**
 * An argument is out of its range; the function says which.
 */
#define TRUEAXIS_ERROR_ARGUMENT 13

/**
 * The buffer is smaller than what is to be written.
 */
#define TRUEAXIS_ERROR_BUFFER 14

/**
 * The segment is no path; details in `trueaxis_error_t`.
 */
#define TRUEAXIS_ERROR_PATH 15

/**
 * The machine file has no gauge (no `[roundness]` section), or one of another number of points.
 */
#define TRUEAXIS_ERROR_GAUGE 16

/**
 * There is no value yet.
 */
#define TRUEAXIS_ERROR_NOT_YET 17

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Version of the library: `major << 16 | minor`, the top bit set for single precision.
 *
 * Real-time safe.
 */
uint32_t trueaxis_abi_version(void);

/**
 * Whether a program compiled with the header of version `header_version` (pass `TRUEAXIS_ABI_VERSION`) can use this
 * library: the same precision, the same major number, and no newer minor one.
 *
 * `TRUEAXIS_ERROR_ABI` otherwise: call nothing else then but `trueaxis_abi_version`, `trueaxis_status_text`, and, to go
 * on uncorrected, `trueaxis_loop_bypass`, `trueaxis_start` and `trueaxis_step`, which refuse structures of another size.
 * Real-time safe.
 */
trueaxis_status_t trueaxis_check_abi(uint32_t header_version);

/**
 * Words for a status: a constant string, never `NULL`, for any number.
 *
 * Real-time safe.
 */
const char *trueaxis_status_text(trueaxis_status_t status);

/**
 * Reads and checks a whole table file and tells what is in it.
 *
 * `file`, `length`: the bytes of a `.tcomp`, anywhere, of any alignment; only read. `info`: its `size` set by the caller.
 * `error`: may be `NULL`; written only on refusal. Not real-time: time linear in the length; takes about 8 KiB of stack.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_TABLES` (with `error->code`).
 */
trueaxis_status_t trueaxis_tables_info(const uint8_t *file,
                                       size_t length,
                                       struct trueaxis_tables_info_t *info,
                                       struct trueaxis_error_t *error);

/**
 * Builds a servo loop from a compiled table file: 3 to 6 axes, as the file says.
 *
 * `loop`, `loop_size`: the caller's, `sizeof(trueaxis_loop_t)`. `file`, `length`: the bytes of the `.tcomp`; may be freed
 * afterwards. `machine_id`: the machine that the file must be for (`trueaxis_tables_info_t.machine_id`); 0 takes any.
 * `period_ns`: servo period, 1,000 to 100,000,000 ns. `memory`, `memory_size`: for the tables, 8-byte aligned, at least
 * `trueaxis_tables_info_t.memory_bytes`; the caller's, must outlive every use of the loop and of its copies, and nobody
 * may write to it in that time. `error`: may be `NULL`; written only on refusal.
 *
 * To exchange tables in motion, build another loop in other memory and pass that to `trueaxis_step` from some cycle on;
 * the limiter leads the correction over, nothing jumps. The old loop's memory is free from then on.
 *
 * Not real-time: time linear in the file's length; takes about 16 KiB of stack. On refusal the loop stays as it was, but
 * `memory` may have been written to.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_TABLES`, `_MACHINE`, `_CONFIG` (also: a period out of range),
 * `_MEMORY`, `_ARGUMENT` (memory overlaps file or loop).
 */
trueaxis_status_t trueaxis_loop_build(struct trueaxis_loop_t *loop,
                                      size_t loop_size,
                                      const uint8_t *file,
                                      size_t length,
                                      uint32_t machine_id,
                                      uint32_t period_ns,
                                      void *memory,
                                      size_t memory_size,
                                      struct trueaxis_error_t *error);

/**
 * Builds a loop that passes every command uncorrected and says why in every record: for going on without tables.
 *
 * `axes`: 3 to 6. `reason`: `TRUEAXIS_FAULT_PERIOD_MISMATCH`, `_TABLES_REFUSED`, `_CAPACITY_TOO_SMALL` or
 * `_ABI_MISMATCH`. `period_ns`: servo period, 1,000 to 100,000,000 ns. It needs no memory. A command that is no usable
 * number is not passed: the last one holds and a stop is requested until the next usable one.
 *
 * Real-time safe. `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_AXES`, `_ARGUMENT` (reason, period).
 */
trueaxis_status_t trueaxis_loop_bypass(struct trueaxis_loop_t *loop,
                                       size_t loop_size,
                                       uint32_t axes,
                                       uint8_t reason,
                                       uint32_t period_ns);

/**
 * A fresh state for a loop, if the host runs at the loop's period (within 0.1 %).
 *
 * `state`, `state_size`: the caller's, `sizeof(trueaxis_state_t)`. Real-time safe.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PERIOD`.
 */
trueaxis_status_t trueaxis_start(const struct trueaxis_loop_t *loop,
                                 struct trueaxis_state_t *state,
                                 size_t state_size,
                                 uint32_t period_ns);

/**
 * One servo cycle: what the drives are sent, and how far the tool is from its path.
 *
 * The first cycle returns the command; from then on `drive = command + correction`. `path`: what the interpolator
 * follows, `reference`: where on it the command of this cycle lies; either may be `NULL`, then no contour error is
 * measured. `input->size` and `output->size` must be set. Loops may be exchanged between two cycles: pass another one
 * of the same number of axes.
 *
 * Real-time safe: no allocation, no lock, no system call, bounded time. On refusal, state and output stay as they were.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`. What goes wrong on the machine is not a
 * status but `output->record.fault`.
 */
trueaxis_status_t trueaxis_step(const struct trueaxis_loop_t *loop,
                                struct trueaxis_state_t *state,
                                const struct trueaxis_input_t *input,
                                const struct trueaxis_path_t *path,
                                const struct trueaxis_reference_t *reference,
                                struct trueaxis_output_t *output);

/**
 * Tells the temperature of an axis; its growth, as the table file describes it, takes effect in the next cycle, through
 * the limiter.
 *
 * `place`: of the axis, 0 = X. `kelvin`: above the reference temperature of the file. Call it between two cycles, from
 * the thread that steps. In a bypass it does nothing. Real-time safe.
 *
 * `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_ARGUMENT` (no such place; `kelvin` not finite or
 * so large that the growth exceeds 10 mm or 1e-3 of the length).
 */
trueaxis_status_t trueaxis_set_thermal(const struct trueaxis_loop_t *loop,
                                       struct trueaxis_state_t *state,
                                       uint32_t place,
                                       double kelvin);

/**
 * Writes the telemetry frame of a record: postcard in COBS, its last byte 0, at most `TRUEAXIS_FRAME_BYTES`; the same
 * bytes in every build and precision.
 *
 * `output`: of a step. `buffer`, `size`: where to. `written`: receives the number of bytes.
 *
 * Bounded time, but not part of the cycle: on a core without double precision some hundred instructions an axis.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_BUFFER`, `_ARGUMENT` (no output of a step).
 */
trueaxis_status_t trueaxis_frame_encode(const struct trueaxis_output_t *output,
                                        uint8_t *buffer,
                                        size_t size,
                                        size_t *written);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRUEAXIS_H */
