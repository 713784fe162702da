/*
 * trueaxis: geometric error compensation and true contour error inside the servo step of an open CNC controller.
 *
 * Generated from the Rust source; do not edit. C99, usable from C++.
 *
 * Rules for all functions
 *   - The answer is a trueaxis_status_t: 0 (TRUEAXIS_OK) or a TRUEAXIS_ERROR_..., never negative. When a function
 *     refuses, everything that it would have written stays as it was (but trueaxis_error_t, which then says why).
 *   - No function panics, allocates, prints, locks or calls the operating system. Of the step itself the linker proves
 *     it; the functions that set up have been tried with damaged files of every kind.
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
