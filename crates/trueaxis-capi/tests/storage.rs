//! Sizes of the objects that the caller provides.

use trueaxis_capi::storage_sizes;

#[test]
fn storage_is_not_much_larger_than_needed() {
    for (name, needed, given) in storage_sizes() {
        println!("{name}: {given} bytes given, {needed} needed = {} words", needed / 8);
        // The sizes in the header are those needed with 64-bit pointers.
        let most = if size_of::<usize>() == 8 { needed + needed / 16 + 96 } else { 2 * needed + 16 };
        assert!(needed <= given && given <= most, "{name}");
    }
}
