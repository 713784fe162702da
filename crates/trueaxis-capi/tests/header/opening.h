/*
 * trueaxis: geometric error compensation and true contour error inside the servo step of an open CNC controller.
 *
 * Generated from the Rust source; do not edit. C99, usable from C++.
 *
 * Rules for all functions
 *   - Functions return TRUEAXIS_OK or a TRUEAXIS_ERROR_... code. Comments list the codes of a function by their
 *     endings, after "Errors:". In addition every function may return _NULL, _SIZE, _ALIGNMENT and _UNBUILT, and a
 *     function of a part that the build leaves out returns _LEFT_OUT. A function that refuses writes nothing (except a
 *     trueaxis_error_t).
 *   - No function panics, allocates, prints, locks or calls the operating system.
 *   - Objects (trueaxis_loop_t, ...) are storage of fixed size that the caller provides and should zero first. They
 *     hold no resources. Memory lent to an object must outlive it. An argument `..._size` is `sizeof` of the object.
 *   - The caller sets the member `size` of a structure that begins with it, once: `input.size = sizeof input;`.
 *   - Pointers are NULL or point to an object of their type. NULL is refused, except for `error` and where a function
 *     allows it. Arguments must not overlap in memory.
 *   - Two threads may use the same loop, path, kinematics and gauge at the same time, never the same state.
 *   - "Real-time safe" functions run in bounded time and may be called in the servo interrupt; call the others at the
 *     start of the program or in a background task. All are reentrant.
 *
 * Units: mm, degrees for rotary axes; time in ns; signs as in ISO 841 and ISO 230-1 (error = actual - ideal).
 *
 * Precision: define TRUEAXIS_SINGLE before including this header if, and only if, the library was built with
 * `--features single`.
 */
