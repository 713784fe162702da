// The version header as the build of controller_interface writes it. DOUBLE_MINOR selects an earlier version.
// SPDX-License-Identifier: MIT OR Apache-2.0
#define CONTROLLER_INTERFACE_VERSION_MAJOR 4
#ifdef DOUBLE_MINOR
#define CONTROLLER_INTERFACE_VERSION_MINOR DOUBLE_MINOR
#else
#define CONTROLLER_INTERFACE_VERSION_MINOR 46
#endif
