//! Writes tables and reads them back with arrow's reader.

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use std::io;
use std::path::Path;
use trueaxis_columnar::{Column, Form, Kind, Value, Writer};

fn columns() -> [Column; 3] {
    [Column::new("axis", Kind::Text), Column::new("cycle", Kind::Whole), Column::new("error_um", Kind::Number)]
}

/// 70,000 rows make two groups.
#[test]
fn parquet_says_the_same_bit_for_bit() {
    let number = |n: i64| if n == 7 { f64::NAN } else { (n as f64).sqrt() / 3.0 };
    let write = || {
        let mut table = Writer::new(Vec::new(), Form::Parquet, &columns()).unwrap();
        for n in 0..70_000 {
            table
                .row([
                    Value::Text(if n % 2 == 0 { "X" } else { "Y, µm" }),
                    Value::Whole(n - 3),
                    Value::Number(number(n)),
                ])
                .unwrap();
        }
        table.finish().unwrap()
    };
    let bytes = write();
    assert_eq!(bytes, write());
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), &bytes).unwrap();
    let reader = SerializedFileReader::new(file.reopen().unwrap()).unwrap();
    assert_eq!(reader.num_row_groups(), 2);
    let mut count = 0;
    for (n, row) in (0..).zip(reader.get_row_iter(None).unwrap()) {
        let row = row.unwrap();
        assert_eq!(row.get_string(0).unwrap(), if n % 2 == 0 { "X" } else { "Y, µm" });
        assert_eq!(row.get_long(1).unwrap(), n - 3);
        assert_eq!(row.get_double(2).unwrap().to_bits(), number(n).to_bits());
        count += 1;
    }
    assert_eq!(count, 70_000);
}

#[test]
fn a_table_without_rows_has_its_columns() {
    let bytes = Writer::new(Vec::new(), Form::Parquet, &columns()).unwrap().finish().unwrap();
    assert_eq!((&bytes[..4], &bytes[bytes.len() - 4..]), (&b"PAR1"[..], &b"PAR1"[..]));
    let bytes = Writer::new(Vec::new(), Form::Csv, &columns()).unwrap().finish().unwrap();
    assert_eq!(bytes, b"axis,cycle,error_um\n");
}

#[test]
fn csv_quotes_and_has_all_digits() {
    let mut table = Writer::new(Vec::new(), Form::Csv, &columns()).unwrap();
    table.row([Value::Text("Y, µm"), Value::Whole(-1), Value::Number(0.1 + 0.2)]).unwrap();
    let text = String::from_utf8(table.finish().unwrap()).unwrap();
    assert_eq!(text, "axis,cycle,error_um\n\"Y, µm\",-1,0.30000000000000004\n");
}

#[test]
fn rows_that_do_not_fit_are_refused() {
    for form in [Form::Parquet, Form::Csv] {
        let mut table = Writer::new(Vec::new(), form, &columns()).unwrap();
        let x = Value::Text("X");
        for (row, said) in [
            (vec![x, Value::Whole(1)], "found 2 values, needed 3"),
            (vec![x, Value::Number(1.0), Value::Number(1.0)], "column cycle: found Number(1.0), needed Whole"),
            (vec![x, Value::Whole(1), Value::Number(1.0), x], "more values than 3"),
        ] {
            let error = table.row(row).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
            assert!(error.to_string().contains(said), "{error}");
            table = Writer::new(Vec::new(), form, &columns()).unwrap();
        }
        assert!(Writer::new(Vec::new(), form, &[]).is_err());
        let twice = [Column::new("a", Kind::Text), Column::new("a", Kind::Whole)];
        assert!(Writer::new(Vec::new(), form, &twice).is_err_and(|error| error.to_string().contains("two columns a")));
    }
    assert_eq!(Form::of(Path::new("a/b.PARQUET")), Some(Form::Parquet));
    assert_eq!(Form::of(Path::new("csv")), None);
}

/// A full disk is reported as a full disk.
#[test]
fn failures_of_the_file_stay_what_they_are() {
    struct Full;
    impl io::Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Err(io::ErrorKind::StorageFull.into())
        }
    }
    for form in [Form::Parquet, Form::Csv] {
        let written = Writer::new(Full, form, &columns()).and_then(|mut table| {
            for n in 0..70_000 {
                table.row([Value::Text("X"), Value::Whole(n), Value::Number(0.0)])?;
            }
            table.finish()
        });
        let error = written.err().unwrap();
        assert!(
            error.kind() == io::ErrorKind::StorageFull || error.to_string().contains("no storage space"),
            "{form:?} {error:?}"
        );
    }
}
