//! Version of the interface.

use crate::result::{ERROR_ABI, OK, ResultCode};

/// Changes when an existing part of the interface changes.
pub const ABI_MAJOR: u32 = 3;
/// Changes when something is added to the interface.
pub const ABI_MINOR: u32 = 4;
/// Set in the version of a single-precision library.
pub const ABI_SINGLE: u32 = 0x8000_0000;
/// Version of this library: `major << 16 | minor`, the top bit set for single precision.
pub const ABI_VERSION: u32 = ABI_MAJOR << 16 | ABI_MINOR | if cfg!(feature = "single") { ABI_SINGLE } else { 0 };

/// Returns the version of the library: `major << 16 | minor`, the top bit set for single precision. Real-time safe.
#[unsafe(no_mangle)]
pub extern "C" fn trueaxis_abi_version() -> u32 {
    ABI_VERSION
}

/// Checks whether a program compiled with a header of version `TRUEAXIS_ABI_VERSION` can use this library: same
/// precision and major number, and a minor number not above the library's. Errors: `_ABI`.
///
/// After `TRUEAXIS_ERROR_ABI` call only `trueaxis_abi_version`, `trueaxis_result_text`, and, to continue uncorrected,
/// `trueaxis_loop_bypass`, `trueaxis_start` and `trueaxis_step`, which refuse structures of another size. Real-time
/// safe.
#[unsafe(no_mangle)]
pub extern "C" fn trueaxis_check_abi(header_version: u32) -> ResultCode {
    let same = header_version >> 16 == ABI_VERSION >> 16;
    if same && header_version <= ABI_VERSION { OK } else { ERROR_ABI }
}
