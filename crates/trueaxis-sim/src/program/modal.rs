//! Modal groups, as in LinuxCNC: G and M words that exclude one another in a line.

/// Groups of G words.
pub(super) mod g {
    pub(in super::super) const ONCE: usize = 0;
    pub(in super::super) const MOTION: usize = 1;
    pub(in super::super) const PLANE: usize = 2;
    pub(in super::super) const DISTANCE: usize = 3;
    pub(in super::super) const CENTER: usize = 4;
    pub(in super::super) const FEED: usize = 5;
    pub(in super::super) const UNIT: usize = 6;
    pub(in super::super) const CUTTER: usize = 7;
    pub(in super::super) const TOOL_LENGTH: usize = 8;
    pub(in super::super) const RETRACT: usize = 10;
    pub(in super::super) const SYSTEM: usize = 12;
    pub(in super::super) const PATH: usize = 13;
    pub(in super::super) const SPINDLE: usize = 14;
    pub(in super::super) const LATHE: usize = 15;
    pub(in super::super) const COUNT: usize = 16;
}

/// Groups of M words.
pub(super) mod m {
    pub(in super::super) const CALL: usize = 0;
    pub(in super::super) const STATE: usize = 1;
    pub(in super::super) const STOP: usize = 4;
    pub(in super::super) const IO: usize = 5;
    pub(in super::super) const TOOL: usize = 6;
    pub(in super::super) const SPINDLE: usize = 7;
    pub(in super::super) const COOLANT: usize = 8;
    pub(in super::super) const OVERRIDE: usize = 9;
    pub(in super::super) const COUNT: usize = 10;
}

/// Supported G words, for messages.
pub(super) const G_WORDS: &str = "G0 G1 G2 G3 G4 G5 G5.1 G5.2 G5.3 G7 G8 G10 G17 G18 G19 G20 G21 G28 G28.1 G30 G30.1 G38.2 to G38.5 G40 G43 G43.1 \
     G43.2 G43.4 G49 G52 G53 G54 to G59.3 G61 G61.1 G64 G73 G80 to G86 G89 G90 G90.1 G91 G91.1 G92 to G92.3 G93 G94 \
     G96 to G99";

/// Supported M words, for messages.
pub(super) const M_WORDS: &str = "M0 to M9 M19 M30 M48 to M53 M60 to M65 M67 M68 M70 to M73 M98 M99";

/// Group of a G word given in tenths, if it is supported.
pub(super) fn g_group(tenths: u16) -> Option<usize> {
    Some(match tenths {
        40 | 100 | 280 | 281 | 300 | 301 | 520 | 530 | 920..=923 => g::ONCE,
        0 | 10 | 20 | 30 | 50..=53 | 382..=385 | 730 | 800 | 810 | 820 | 830 | 840 | 850 | 860 | 890 => g::MOTION,
        170 | 180 | 190 => g::PLANE,
        900 | 910 => g::DISTANCE,
        901 | 911 => g::CENTER,
        930 | 940 => g::FEED,
        200 | 210 => g::UNIT,
        400 => g::CUTTER,
        430 | 431 | 432 | 434 | 490 => g::TOOL_LENGTH,
        980 | 990 => g::RETRACT,
        540 | 550 | 560 | 570 | 580 | 590..=593 => g::SYSTEM,
        610 | 611 | 640 => g::PATH,
        960 | 970 => g::SPINDLE,
        70 | 80 => g::LATHE,
        _ => return None,
    })
}

/// Group of an M word, if it is supported.
pub(super) fn m_group(number: u16) -> Option<usize> {
    Some(match number {
        0 | 1 | 2 | 30 | 60 => m::STOP,
        62..=65 | 67 | 68 => m::IO,
        6 | 61 => m::TOOL,
        3 | 4 | 5 | 19 => m::SPINDLE,
        7..=9 => m::COOLANT,
        48..=53 => m::OVERRIDE,
        70..=73 => m::STATE,
        98 | 99 => m::CALL,
        _ => return None,
    })
}

/// Whether LinuxCNC executes a G word that is not supported here: its own interpreter can then read the program.
pub(super) fn linuxcnc_has_g(tenths: u16) -> bool {
    matches!(tenths, 330 | 331 | 410 | 411 | 420 | 421 | 700..=722 | 740 | 760 | 870 | 880 | 950)
}

/// Whether LinuxCNC executes an M word that is not supported here.
pub(super) fn linuxcnc_has_m(number: u16) -> bool {
    number == 66
}

/// G54, G55 … G59.3 as 1 to 9.
pub(super) fn system_number(tenths: u16) -> usize {
    match tenths {
        540..=590 => usize::from(tenths - 540) / 10 + 1,
        _ => usize::from(tenths.saturating_sub(590)) + 6,
    }
}
