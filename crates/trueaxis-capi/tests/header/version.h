/* Version of this header. Compare it with the library's by calling trueaxis_check_abi(TRUEAXIS_ABI_VERSION). */
#ifndef TRUEAXIS_ABI_MAJOR
#define TRUEAXIS_ABI_MAJOR @MAJOR@
#endif
#ifndef TRUEAXIS_ABI_MINOR
#define TRUEAXIS_ABI_MINOR @MINOR@
#endif
#ifdef TRUEAXIS_SINGLE
#define TRUEAXIS_ABI_VERSION (UINT32_C(0x80000000) | (uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#else
#define TRUEAXIS_ABI_VERSION ((uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#endif
