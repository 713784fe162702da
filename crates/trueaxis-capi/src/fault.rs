//! Codes of `trueaxis_record_t.fault`.

/// No fault.
pub const FAULT_NONE: u8 = 0;
/// A reading is not finite. With faults 1 to 11 the correction freezes and the command passes.
pub const FAULT_FEEDBACK_NOT_FINITE: u8 = 1;
/// A reading changed in one cycle by more than the axis can move, or is more than 1 mm (1 degree) outside the joint's
/// range.
pub const FAULT_FEEDBACK_JUMP: u8 = 2;
/// A reading does not change although the axis is commanded to move.
pub const FAULT_ENCODER_STUCK: u8 = 3;
/// The encoder interface reports an alarm (dropout).
pub const FAULT_ENCODER_ALARM: u8 = 4;
/// `elapsed_ns` differs from the period by more than a quarter, or too many cycles came early.
pub const FAULT_LATE_CYCLE: u8 = 5;
/// A reading moves against the command, or by about half or twice as much: sign or scale of the encoder are wrong.
pub const FAULT_FEEDBACK_RATIO: u8 = 6;
/// An axis whose friction adapts sticks and slips. Faults 12 to 15 are reported until a reset, while the correction
/// continues with the identified friction.
pub const FAULT_STICK_SLIP: u8 = 12;
/// The friction of an axis that adapts has the wrong sign at its reversals.
pub const FAULT_FRICTION_REVERSED: u8 = 13;
/// A command is not finite. With faults 16 to 31 the output holds and the step requests a stop.
pub const FAULT_COMMAND_NOT_FINITE: u8 = 16;
/// A command is outside the declared travel.
pub const FAULT_COMMAND_OUT_OF_TRAVEL: u8 = 17;
/// A command changed in one cycle by more than the axis can move.
pub const FAULT_COMMAND_JUMP: u8 = 18;
/// Command plus correction leaves the range of the joint.
pub const FAULT_JOINT_RANGE: u8 = 19;
/// The machine has no pose with the commanded tip and direction.
pub const FAULT_TOOL_UNREACHABLE: u8 = 20;
/// The pose is in the singular cone, and the end of a rotary travel keeps the tool further off than the cone.
pub const FAULT_SINGULAR_POSE: u8 = 21;
/// The commanded direction needs the other branch of the rotary axes.
pub const FAULT_BRANCH_CHANGE: u8 = 22;
/// The host's period is not the configured one. Faults from 32 on are reasons of a `trueaxis_loop_bypass`.
pub const FAULT_PERIOD_MISMATCH: u8 = 32;
/// The table file was refused.
pub const FAULT_TABLES_REFUSED: u8 = 33;
/// The tables need more memory than was lent.
pub const FAULT_CAPACITY_TOO_SMALL: u8 = 34;
/// Header and library differ in version.
pub const FAULT_ABI_MISMATCH: u8 = 35;
