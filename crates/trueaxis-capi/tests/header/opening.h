/*
 * trueaxis: geometric error compensation and true contour error inside the servo step of an open CNC controller.
 *
 * Generated from the Rust source; do not edit. C99, usable from C++.
 *
 * Rules for all functions
 *   - The answer is TRUEAXIS_OK or a TRUEAXIS_ERROR_...; comments name the latter by their endings. Every function may
 *     answer _NULL, _SIZE, _ALIGNMENT and _UNBUILT. A function that refuses writes nothing (but a trueaxis_error_t).
 *   - No function panics, allocates, prints, locks or calls the operating system.
 *   - Objects (trueaxis_loop_t, ...) are storage of fixed size that the caller provides, best zeroed before; they hold no
 *     resources. Memory lent to an object must outlive it. Arguments `..._size` are `sizeof` of the object.
 *   - The caller sets the member `size` of a structure that begins with it, once: `input.size = sizeof input;`.
 *   - Pointers are NULL or point to what their type says. NULL is refused but for `error` and where a function allows it.
 *     Arguments must not overlap in memory.
 *   - Two threads may use the same loop, path, kinematics and gauge at the same time, never the same state.
 *   - "Real-time safe" functions run in bounded time and may be called in the servo interrupt; the others belong to the
 *     start of the program or a background task. All are reentrant.
 *
 * Units: mm, for rotary axes degrees; time ns; signs as in ISO 841 and ISO 230-1 (error = actual - ideal).
 *
 * Precision: define TRUEAXIS_SINGLE before including this header for a library built with `--features single`, and only
 * then.
 */
