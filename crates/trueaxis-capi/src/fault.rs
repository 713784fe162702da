//! Codes of `trueaxis_record_t.fault`.

/// Nothing is wrong.
pub const FAULT_NONE: u8 = 0;
/// An encoder gave no finite reading. From here to 15: the correction freezes and the command passes.
pub const FAULT_FEEDBACK_NOT_FINITE: u8 = 1;
/// A reading changed more in a cycle than the axis can move.
pub const FAULT_FEEDBACK_JUMP: u8 = 2;
/// A reading stands still though the axis was commanded to move.
pub const FAULT_ENCODER_STUCK: u8 = 3;
/// The encoder interface reports an alarm (dropout).
pub const FAULT_ENCODER_ALARM: u8 = 4;
/// The cycle came late: its period is off by more than a quarter.
pub const FAULT_LATE_CYCLE: u8 = 5;
/// A command is infinite or not a number. From here to 31: the output holds and a stop is requested.
pub const FAULT_COMMAND_NOT_FINITE: u8 = 16;
/// A command lies outside the declared travel.
pub const FAULT_COMMAND_OUT_OF_TRAVEL: u8 = 17;
/// A command changed more in a cycle than the axis can move.
pub const FAULT_COMMAND_JUMP: u8 = 18;
/// Command plus correction leaves the range of the joint.
pub const FAULT_JOINT_RANGE: u8 = 19;
/// No pose of the machine brings the tool to the commanded tip and direction.
pub const FAULT_TOOL_UNREACHABLE: u8 = 20;
/// The commanded direction is too near to the singular one.
pub const FAULT_SINGULAR_POSE: u8 = 21;
/// The commanded direction asks the rotary axes to go over to their other solution faster than they can.
pub const FAULT_BRANCH_CHANGE: u8 = 22;
/// The host's servo period is not the configured one. From here on: refused at start, the command passes uncorrected
/// (`trueaxis_loop_bypass`).
pub const FAULT_PERIOD_MISMATCH: u8 = 32;
/// The table file is damaged, or of another format, version or machine.
pub const FAULT_TABLES_REFUSED: u8 = 33;
/// The tables need more memory than there is.
pub const FAULT_CAPACITY_TOO_SMALL: u8 = 34;
/// Host and library were built for different versions of the interface.
pub const FAULT_ABI_MISMATCH: u8 = 35;
