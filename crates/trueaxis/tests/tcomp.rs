//! The compiled file compared with an independent writer, made from the description of the format, with a bitwise
//! CRC-32.

use trueaxis::machine::{Axis, AxisSettings, MachineSettings, ThermalGrowth};
use trueaxis::tcomp::{Stored, TableHeader, Tcomp, TcompError, checksum, machine_id};
use trueaxis_testing::machine::Machine;

/// CRC-32/ISO-HDLC: polynomial 0x04C11DB7 reflected, initial value and final XOR all ones.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xEDB8_8320 } else { sum >> 1 })
    })
}

/// One table: its header, and its numbers line by line.
type Table = (TableHeader, Vec<f64>);

const NONE: TableHeader = TableHeader { present: false, given: 0, bidirectional: false, rows: 0 };

fn payload(machine: &MachineSettings, tables: &[Table]) -> Vec<u8> {
    let mut buffer = vec![0; 1 << 16];
    let mut bytes = postcard::to_slice(&Stored(machine), &mut buffer).unwrap().to_vec();
    for (header, numbers) in tables {
        bytes.extend_from_slice(postcard::to_slice(header, &mut [0; 64]).unwrap());
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }
    bytes
}

fn file(id: u32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = b"TRUEAXIS".to_vec();
    bytes.extend(4_u16.to_le_bytes());
    bytes.extend(id.to_le_bytes());
    bytes.extend((payload.len() as u32).to_le_bytes());
    bytes.extend(payload);
    bytes.extend(crc(&bytes).to_le_bytes());
    bytes
}

fn machine() -> MachineSettings {
    Machine::three_axis().name("mill").travel([-100.0, 100.0], 1.0).hysteresis(0.01).settings()
}

fn id() -> u32 {
    crc(b"mill\nw b X Y Z t")
}

/// X in both directions with two components, Y in one direction with three, Z without a table.
fn tables() -> [Table; 3] {
    let x = TableHeader { present: true, given: 0b000101, bidirectional: true, rows: 3 };
    let y = TableHeader { present: true, given: 0b100011, bidirectional: false, rows: 2 };
    let of_x =
        [[-100.0, 1e-3, 2e-3, 1.5e-3, 2.5e-3], [0.0, 3e-3, 4e-3, 3.5e-3, 4.5e-3], [100.0, 5e-3, 6e-3, 5.5e-3, 6.5e-3]];
    let of_y = [[-90.0, 7e-3, 8e-3, 1e-6], [90.0, 9e-3, 9.5e-3, 2e-6]];
    [(x, of_x.concat()), (y, of_y.concat()), (NONE, Vec::new())]
}

#[test]
fn a_written_file_is_read_back() {
    assert_eq!(crc(b"123456789"), 0xCBF4_3926);
    assert_eq!((checksum(b"123456789"), machine_id("mill", "w b X Y Z t")), (0xCBF4_3926, id()));
    let bytes = file(id(), &payload(&machine(), &tables()));
    let tcomp = Tcomp::parse(&bytes).unwrap();
    assert_eq!(tcomp.settings(), &machine());
    assert_eq!((tcomp.machine_id(), tcomp.crc()), (id(), crc(&bytes[..bytes.len() - 4])));
    assert_eq!((tcomp.expect_machine(id()), tcomp.expect_machine(id() ^ 1)), (Ok(()), Err(TcompError::WrongMachine)));
    assert!(tcomp.inverse_passes() > 1);
    let x = tcomp.table(Axis::X).unwrap();
    assert_eq!(x.given(), [true, false, true, false, false, false]);
    assert!(x.bidirectional() && x.len() == 3 && !x.is_empty() && x.rows().count() == 3);
    let row = x.row(1).unwrap();
    assert_eq!(
        (row.position, row.forward, row.reverse),
        (0.0, [3e-3, 0.0, 4e-3, 0.0, 0.0, 0.0], [3.5e-3, 0.0, 4.5e-3, 0.0, 0.0, 0.0],)
    );
    assert!(x.row(3).is_none() && x.row(usize::MAX).is_none());
    assert_eq!(x.rows().map(|row| row.position).collect::<Vec<_>>(), [-100.0, 0.0, 100.0]);
    let y = tcomp.table(Axis::Y).unwrap();
    assert_eq!(y.given(), [true, true, false, false, false, true]);
    assert!(!y.bidirectional() && y.len() == 2);
    let row = y.row(1).unwrap();
    assert_eq!((row.position, row.forward), (90.0, [9e-3, 9.5e-3, 0.0, 0.0, 0.0, 2e-6]));
    assert_eq!(row.reverse, row.forward);
    assert!(tcomp.table(Axis::Z).is_none() && tcomp.table(Axis::A).is_none());
    let present: Vec<bool> = tcomp.axes().map(|(_, table)| table.is_some()).collect();
    assert_eq!(present, [true, true, false]);
    assert!(tcomp.axes().map(|(axis, _): (&AxisSettings, _)| axis.axis).eq([Axis::X, Axis::Y, Axis::Z]));
    // Nine terms of linear tables: four numbers for value and slope of each point, in both directions for X; the points
    // of X and Y are equally spaced.
    assert_eq!(tcomp.requirement(), 3 * 2 * 2 * 4 + 2 * 2 * 4);
    assert_eq!((tables()[0].0.row_bytes(), tables()[1].0.row_bytes()), (40, 32));
}

fn refused(bytes: &[u8]) -> TcompError {
    Tcomp::parse(bytes).unwrap_err()
}

/// Parses the file with a changed payload and a new checksum; returns the error.
fn with(change: impl FnOnce(&mut MachineSettings, &mut Vec<Table>)) -> TcompError {
    let (mut machine, mut tables) = (machine(), tables().to_vec());
    change(&mut machine, &mut tables);
    refused(&file(id(), &payload(&machine, &tables)))
}

#[test]
fn errors_are_named() {
    let good = file(id(), &payload(&machine(), &tables()));
    for length in 0..good.len() {
        assert_eq!(refused(&good[..length]), TcompError::TooShort, "{length} bytes");
    }
    let longer: Vec<u8> = good.iter().copied().chain([0]).collect();
    assert_eq!(refused(&longer), TcompError::TooLong);
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut bytes = good.clone();
            bytes[at] ^= 1 << bit;
            let error = refused(&bytes);
            let wanted = match at {
                0..8 => TcompError::Magic,
                // One bit gives the version with grids or with encoders, which are accepted.
                8 if bit < 2 => TcompError::Checksum,
                8..10 => TcompError::Version,
                // Too small a length leaves bytes after the checksum; too large a one exceeds the file.
                14..18 if error != TcompError::TooLong => TcompError::TooShort,
                14..18 => TcompError::TooLong,
                _ => TcompError::Checksum,
            };
            assert_eq!(error, wanted, "byte {at}, bit {bit}");
        }
    }
    assert_eq!(refused(&file(id() ^ 1, &payload(&machine(), &tables()))), TcompError::MachineId);
    assert_eq!(refused(&file(id(), &[])), TcompError::Settings);
    assert_eq!(refused(&file(id(), &payload(&machine(), &tables()[..2]))), TcompError::TableHeader);
    assert_eq!(with(|_, tables| tables.push((NONE, Vec::new()))), TcompError::PayloadTooLong);
    assert_eq!(with(|_, tables| tables[1].0.rows = 9), TcompError::TableTooLong);
    assert_eq!(with(|_, tables| tables[1].0.rows = u32::MAX), TcompError::TableTooLong);
    for unsound in [
        TableHeader { rows: 1, ..NONE },
        TableHeader { given: 1, ..NONE },
        TableHeader { bidirectional: true, ..NONE },
        TableHeader { present: true, given: 0, rows: 2, bidirectional: false },
        TableHeader { present: true, given: 64, rows: 0, bidirectional: false },
    ] {
        assert_eq!(with(|_, tables| tables[2] = (unsound, vec![0.0; 2])), TcompError::TableHeader, "{unsound:?}");
    }
    // A header with all six components is valid: the content is refused.
    let all = TableHeader { present: true, given: 63, bidirectional: false, rows: 2 };
    assert!(matches!(with(|_, tables| tables[2] = (all, vec![1.0; 14])), TcompError::Content(_)));
    assert!(matches!(with(|machine, _| machine.axes[0].hysteresis = -1.0), TcompError::Content(_)));
}

/// The names without `bench`: what a host reads beside the loop.
#[test]
fn a_host_reads_the_machine_without_its_settings() {
    let mut machine = machine();
    machine.axes[0].thermal = ThermalGrowth { offset_per_k: 2e-3, expansion_per_k: 11e-6, datum: 0.0 };
    let bytes = file(id(), &payload(&machine, &tables()));
    let tables = Tcomp::parse(&bytes).unwrap();
    assert_eq!((tables.name(), tables.chain()), ("mill", "w b X Y Z t"));
    assert_eq!(tables.slots().collect::<Vec<_>>(), [Axis::X, Axis::Y, Axis::Z]);
    assert_eq!(tables.travel(Axis::Y), Some([-100.0, 100.0]));
    assert_eq!((tables.travel(Axis::C), tables.growth::<f64>(Axis::C, 1.0)), (None, None));
    // 11 µm per metre and kelvin, and 2 µm: 3 K lengthen 500 mm by 16.5 µm + 6 µm.
    let line = tables.growth::<f64>(Axis::X, 3.0).unwrap();
    assert!((line.at(500.0) - 22.5e-3).abs() < 1e-15);
    assert_eq!(tables.growth::<f64>(Axis::X, f64::NAN), None);
    let tool = tables.kinematics::<f64>().unwrap().forward(&[1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
    assert_eq!(<[f64; 3]>::from(tool.axis), [0.0, 0.0, 1.0]);
    assert!(tables.gauge::<f64, 256>(250_000).unwrap().is_none());
}

#[test]
fn errors_have_a_code_and_a_sentence() {
    let content = with(|machine, _| machine.axes[0].hysteresis = -1.0);
    let TcompError::Content(inner) = content else { panic!("{content}") };
    assert_eq!((content.code(), content.to_string()), (11, inner.to_string()));
    let all = [
        (TcompError::TooShort, "shorter"),
        (TcompError::TooLong, "longer"),
        (TcompError::Magic, "TRUEAXIS"),
        (TcompError::Version, "version"),
        (TcompError::Checksum, "CRC-32"),
        (TcompError::Settings, "settings"),
        (TcompError::TableHeader, "header of a table"),
        (TcompError::TableTooLong, "longer than the payload"),
        (TcompError::PayloadTooLong, "last item"),
        (TcompError::MachineId, "name and chain"),
    ];
    for (code, (error, word)) in (1..).zip(all) {
        assert_eq!(error.code(), code);
        assert!(error.to_string().contains(word), "{error}");
    }
    assert_eq!(TcompError::WrongMachine.code(), 12);
}
