//! Runs the cycle against a process image of simulated drives: start-up, lost and late frames, faults, refused tables.

use trueaxis::telemetry::Status;
use trueaxis::{Fault, HostServo};
use trueaxis_ethercat::{AXES, Cycle, Frame, IMAGE_BYTES, LOST_MAX, PERIOD_NS, Report, Stop, tables};

const TABLES: &[u8] = include_bytes!("../../../crates/trueaxis/mill-3axis.tcomp");
const COUNTS_PER_MM: f64 = 100_000.0;
const START: [i32; AXES] = [1_000_000, -2_000_000, -20_000_000];

/// CiA 402 drives that reach the target of the previous cycle.
struct Drives {
    inputs: [[u8; IMAGE_BYTES]; AXES],
    outputs: [[u8; IMAGE_BYTES]; AXES],
    status: [u16; AXES],
    position: [i32; AXES],
    time_ns: u64,
}

impl Drives {
    fn new() -> Self {
        let blank = [[0; IMAGE_BYTES]; AXES];
        Drives { inputs: blank, outputs: blank, status: [0x40; AXES], position: START, time_ns: 5_000_000_000 }
    }

    fn control(&self, drive: usize) -> u16 {
        u16::from_le_bytes([self.outputs[drive][0], self.outputs[drive][1]])
    }

    fn target(&self, drive: usize) -> i32 {
        i32::from_le_bytes(self.outputs[drive][2..].try_into().unwrap())
    }

    /// Simulates a frame that arrives after `elapsed` ns. If the answer is lost, the inputs keep their old values.
    fn exchange(&mut self, elapsed: u64, lost: bool) -> Frame {
        self.time_ns += elapsed;
        for drive in 0..AXES {
            self.status[drive] = match (self.status[drive], self.control(drive)) {
                (fault @ 0x08, _) => fault,
                (0x40 | 0x07, 0x06) => 0x21,
                (0x21, 0x07) => 0x23,
                (0x23, 0x0f) => 0x27,
                (0x27 | 0x23 | 0x21, 0x02) => 0x07, // quick stop, then switched off
                (status, _) => status,
            };
            if self.status[drive] == 0x27 {
                self.position[drive] = self.target(drive);
            }
            if !lost {
                self.inputs[drive][..2].copy_from_slice(&self.status[drive].to_le_bytes());
                self.inputs[drive][2..].copy_from_slice(&self.position[drive].to_le_bytes());
            }
        }
        if lost { Frame::Lost } else { Frame::Received { system_time_ns: self.time_ns } }
    }

    fn cycle(&mut self, cycle: &mut Cycle, command: [f64; AXES], elapsed: u32, lost: bool) -> Report {
        let frame = self.exchange(elapsed.into(), lost);
        cycle.run(frame, &self.inputs.clone(), command, &mut self.outputs)
    }
}

/// A command that moves X at 20 mm/s from the drives' position.
fn command(n: u32) -> [f64; AXES] {
    let start = START.map(|counts| f64::from(counts) / COUNTS_PER_MM);
    [start[0] + 0.02 * f64::from(n), start[1], start[2]]
}

/// Runs `test` on a machine that has started and has moved for a second.
fn moving(test: impl FnOnce(&HostServo<AXES>, &mut Cycle, &mut Drives, &mut u32)) {
    let file = tables(TABLES).unwrap();
    let mut memory = vec![0.0; file.requirement()];
    let servo = HostServo::<AXES>::load(&file, PERIOD_NS, &mut memory).unwrap();
    let (mut cycle, mut drives, mut n) = (Cycle::new(&servo, COUNTS_PER_MM), Drives::new(), 0);
    for i in 0..10 {
        let before = drives.status;
        // Until all drives follow, the command has no effect.
        let early = command(if i < 3 { 500 } else { 0 });
        let report = drives.cycle(&mut cycle, early, PERIOD_NS, false);
        assert_eq!(report.stop, None);
        if before.iter().any(|status| *status != 0x27) {
            assert_eq!(drives.position, START, "nothing moves before all drives follow");
        }
    }
    for _ in 0..1000 {
        n += 1;
        let report = drives.cycle(&mut cycle, command(n), PERIOD_NS, false);
        assert!(report.running && report.output.record.fault == Fault::None, "{}", report.output.record.fault);
    }
    test(&servo, &mut cycle, &mut drives, &mut n);
}

fn off_command(drives: &Drives, n: u32) -> [f64; AXES] {
    let command = command(n);
    core::array::from_fn(|i| f64::from(drives.target(i)) / COUNTS_PER_MM - command[i])
}

#[test]
fn drives_get_command_plus_correction() {
    moving(|servo, _, drives, n| {
        // C0Y, A0Z and other errors shift Y and Z by several micrometres there; the stateless lookup gives the exact
        // values.
        let wanted = servo.correction_at(&command(*n), &trueaxis::Conditions::default()).unwrap();
        let sent = off_command(drives, *n);
        for (i, (sent, wanted)) in sent.iter().zip(wanted).enumerate().skip(1) {
            // Y and Z are at rest, so their lost motion may lie on either side.
            assert!((sent - wanted).abs() < 0.0025, "axis {i}: {sent} sent, {wanted} wanted");
        }
        assert!(sent.iter().any(|sent| sent.abs() > 0.002), "{sent:?}");
    });
}

/// Drives with 0.1 nm per count, whose positions wrap at 214.7 mm.
#[test]
fn positions_go_on_beyond_32_bits() {
    let counts_per_mm = 1e7;
    let file = tables(TABLES).unwrap();
    let mut memory = vec![0.0; file.requirement()];
    let servo = HostServo::<AXES>::load(&file, PERIOD_NS, &mut memory).unwrap();
    let mut cycle = Cycle::new(&servo, counts_per_mm);
    let mut drives = Drives { position: [2_140_000_000, -200_000_000, -2_000_000_000], ..Drives::new() };
    for n in 0..2000_i32 {
        // Out and back.
        let x = 214.0 + 0.02 * f64::from((1000 - (n - 1010).abs()).max(0));
        let report = drives.cycle(&mut cycle, [x, -20.0, -200.0], PERIOD_NS, false);
        assert_eq!((report.stop, report.output.record.fault), (None, Fault::None), "cycle {n}");
        assert!(!report.running || (cycle.position()[0] - x).abs() < 0.1, "cycle {n}");
        assert!(x < 214.8 || drives.position[0] < 0, "cycle {n}: not wrapped");
    }
}

#[test]
fn a_lost_frame_freezes_the_correction_and_the_command_passes() {
    moving(|_, cycle, drives, n| {
        let frozen = off_command(drives, *n);
        for _ in 1..LOST_MAX {
            *n += 1;
            let report = drives.cycle(cycle, command(*n), PERIOD_NS, true);
            assert!(report.running && report.stop.is_none());
            assert_eq!(report.output.record.fault, Fault::EncoderAlarm);
            assert!(report.output.record.status.has(Status::FROZEN));
            for (now, before) in off_command(drives, *n).iter().zip(frozen) {
                assert!((now - before).abs() < 1.5e-5, "{now} {before}");
            }
        }
        // The clock advances through lost frames, which does not make the cycle late.
        for i in 0..10 {
            *n += 1;
            let report = drives.cycle(cycle, command(*n), PERIOD_NS, false);
            assert_eq!(report.output.record.fault, Fault::None, "cycle {i} after the loss");
        }
    });
}

#[test]
fn a_late_frame_freezes_one_cycle_and_so_does_an_early_one() {
    moving(|_, cycle, drives, n| {
        for (elapsed, fault) in [
            (PERIOD_NS * 5 / 4 - 1000, Fault::None),
            (PERIOD_NS * 13 / 10, Fault::LateCycle),
            (PERIOD_NS, Fault::None),
            (PERIOD_NS / 2, Fault::LateCycle), // the one after a late one comes early
            (PERIOD_NS, Fault::None),
        ] {
            *n += 1;
            let report = drives.cycle(cycle, command(*n), elapsed, false);
            assert_eq!(report.output.record.fault, fault, "{elapsed} ns");
            assert_eq!(report.output.record.status.has(Status::FROZEN), fault == Fault::LateCycle);
            assert!(report.running);
        }
    });
}

#[test]
fn a_clock_that_is_set_back_or_far_ahead_is_a_late_cycle() {
    moving(|_, cycle, drives, n| {
        // Cut to 32 bits, 2^32 ns plus a period would be one period. The last two step back by a millisecond and a
        // nanosecond.
        for elapsed in [(1 << 32) + u64::from(PERIOD_NS), 1 << 40, u64::MAX - 999_999, u64::MAX] {
            for (elapsed, fault) in [(elapsed, Fault::LateCycle), (u64::from(PERIOD_NS), Fault::None)] {
                *n += 1;
                drives.time_ns = drives.time_ns.wrapping_add(elapsed);
                let frame = drives.exchange(0, false);
                let report = cycle.run(frame, &drives.inputs.clone(), command(*n), &mut drives.outputs);
                assert_eq!(report.output.record.fault, fault, "{elapsed} ns");
                assert!(report.running);
            }
        }
    });
}

#[test]
fn frames_that_stay_away_stop_the_machine_until_a_reset() {
    moving(|_, cycle, drives, n| {
        for i in 1..=LOST_MAX + 2 {
            *n += 1;
            let report = drives.cycle(cycle, command(*n), PERIOD_NS, true);
            assert_eq!(report.stop, (i >= LOST_MAX).then_some(Stop::Frames), "frame {i}");
        }
        let held = drives.outputs;
        assert!((0..AXES).all(|drive| drives.control(drive) == 0x02));
        let report = drives.cycle(cycle, command(*n), PERIOD_NS, true);
        assert!(!report.running && held == drives.outputs, "targets hold");
        // When frames return, the machine stays stopped, with the drives' positions as targets.
        for _ in 0..5 {
            let report = drives.cycle(cycle, command(*n), PERIOD_NS, false);
            assert_eq!(report.stop, Some(Stop::Frames));
            assert!((0..AXES).all(|drive| drives.target(drive) == drives.position[drive]));
        }
        let stood = drives.position;
        cycle.reset();
        let mut running = false;
        for _ in 0..10 {
            let here = cycle.position();
            running = drives.cycle(cycle, here, PERIOD_NS, false).running;
        }
        assert!(running, "comes back into operation");
        // The correction changes by at most the limiter's step, without a jump.
        assert!(
            stood.iter().zip(drives.position).all(|(a, b)| (a - b).abs() < 3000),
            "{stood:?} {:?}",
            drives.position
        );
    });
}

#[test]
fn a_fault_of_one_drive_stops_all() {
    moving(|_, cycle, drives, n| {
        drives.status[1] = 0x08;
        let report = drives.cycle(cycle, command(*n + 1), PERIOD_NS, false);
        assert_eq!(report.stop, Some(Stop::Drive(1)));
        assert!((0..AXES).all(|drive| drives.control(drive) == 0x02));
    });
}

#[test]
fn a_command_that_jumps_stops_the_machine() {
    for bad in [f64::NAN, 150.0, 1e6] {
        moving(|_, cycle, drives, n| {
            let before = drives.outputs.map(|image| i32::from_le_bytes(image[2..].try_into().unwrap()));
            let report = drives.cycle(cycle, [bad, command(*n)[1], command(*n)[2]], PERIOD_NS, false);
            assert!(matches!(report.stop, Some(Stop::Command(_))), "{bad}: {:?}", report.stop);
            assert!(before.iter().enumerate().all(|(drive, before)| (drives.target(drive) - before).abs() < 3000));
        });
    }
}

#[test]
fn refused_tables_are_reported_and_commands_pass() {
    let mut damaged = TABLES.to_vec();
    damaged[5000] ^= 1;
    let Err(message) = tables(&damaged) else { panic!("taken") };
    assert_eq!(message, "trueaxis: the file is damaged (its CRC-32 is wrong); running uncompensated");
    let (mut cycle, mut drives) = (Cycle::uncompensated(Fault::TablesRefused, COUNTS_PER_MM), Drives::new());
    for n in 0..100_u32 {
        let n = n.saturating_sub(20);
        let report = drives.cycle(&mut cycle, command(n), PERIOD_NS, false);
        assert_eq!((report.stop, report.output.record.fault), (None, Fault::TablesRefused));
    }
    assert!(off_command(&drives, 79).iter().all(|off| off.abs() < 1e-5));
}
