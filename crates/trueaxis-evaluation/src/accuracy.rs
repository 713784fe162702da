//! Positioning accuracy and repeatability after ISO 230-2.
