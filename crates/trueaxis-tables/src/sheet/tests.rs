//! Files as spreadsheets write them, and refusals.

use super::lines::LONGEST_LINE;
use super::*;

/// The dialect of a text, and its rows with their lines.
type Found = (Option<&'static str>, Vec<(u32, Vec<f64>)>);

fn read(text: &[u8]) -> Result<Found, FileError> {
    let mut sheet = Sheet::new(text, Path::new("t.csv"))?;
    let mut rows = Vec::new();
    while sheet.next_row()? {
        let numbers = (0..sheet.header().len()).map(|column| sheet.number(column)).collect::<Result<_, _>>()?;
        rows.push((sheet.line(), numbers));
    }
    Ok((sheet.dialect(), rows))
}

fn refused(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn files_as_spreadsheets_write_them() {
    let truth = vec![(2, vec![1.5, -2.25]), (3, vec![3.0, 4e-3])];
    let plain: [(&str, Option<&str>); 8] = [
        ("x,y\n1.5,-2.25\n3,4e-3\n", None),
        ("\u{feff}x,y\r\n1.5,-2.25\r\n3,4e-3", None),
        ("x;y\n1,5;-2,25\n3;4e-3\n", Some("read as semicolon separated with decimal commas")),
        ("x;y\n1.5;-2.25\n3;4e-3\n", Some("read as semicolon separated")),
        ("x\ty\n1.5\t-2.25\n3\t4e-3\n", Some("read as tab separated")),
        ("x\ty\n1,5\t-2,25\n3\t4e-3\n", Some("read as tab separated with decimal commas")),
        ("\"x\",\"y\"\n\"1,5\",\"-2,25\"\n\"3\",4e-3\n", Some("read as comma separated with decimal commas in quotes")),
        ("x, y\n1.5, \"-2.25\"\n 3 ,4e-3\n", None),
    ];
    for (text, dialect) in plain {
        assert_eq!(read(text.as_bytes()).unwrap(), (dialect, truth.clone()), "{text:?}");
    }
    // Comments may be in any encoding; lines are counted with them.
    let (_, rows) = read(b"# \xb5m\n\n  # more, \"\nx,y\n# here\n1,2\n\n3,4\n").unwrap();
    assert_eq!(rows, [(6, vec![1.0, 2.0]), (8, vec![3.0, 4.0])]);
    // Three decimals everywhere are decimals if semicolons separate the fields, or once another number shows it.
    assert_eq!(read(b"x;y\n1,234;5\n").unwrap().1, [(2, vec![1.234, 5.0])]);
    assert_eq!(read(b"x\ty\n1,234\t5\n0,500\t2\n").unwrap().1, [(2, vec![1.234, 5.0]), (3, vec![0.5, 2.0])]);
}

#[test]
fn nothing_is_guessed() {
    for (text, parts) in [
        ("x,y\n1,5,2,5\n", ["t.csv:2", "4 values", "semicolons"]),
        ("x,y;z\n1,2;3\n", ["t.csv:1", "commas and semicolons", "one of"]),
        ("x\ty\n1,234\t5,678\n", ["t.csv:2", "1,234", "thousands"]),
        ("x,y\n\"1,234\",5\n", ["t.csv:2", "1,234", "thousands"]),
        ("x;y\n1,5;2.5\n", ["t.csv:2", "2.5", "decimal comma"]),
        ("x;y\n1.5;2\n1;2,5\n", ["t.csv:3", "2,5", "decimal point"]),
        ("x;y\n1.234,5;2\n", ["t.csv:2", "1.234,5", "thousands"]),
        ("x;y\n1,234,567;2\n", ["t.csv:2", "1,234,567", "a number"]),
        ("x,y\n\"1,2\n3,4\n", ["t.csv:2", "open quote", "closed"]),
        ("x,y\n1\n", ["t.csv:2", "1 value", "2 as in the header"]),
        ("x,y\n1,\n", ["t.csv:2: column y", "nothing", "a number"]),
        ("# no more\n", ["t.csv", "no header", "names"]),
        ("0,1\n2,3\n", ["t.csv:1", "found 0,1", "names of the columns in the first line"]),
        ("0;1\n2;3\n", ["t.csv:1", "found 0;1", "names of the columns in the first line"]),
    ] {
        let error = refused(text);
        for part in parts {
            assert!(error.contains(part), "{text:?}: {error}");
        }
    }
    let latin = read(b"x,y\n1,2\n\xb5,2\n").unwrap_err();
    assert_eq!((latin.line, latin.found.as_str()), (Some(3), "bytes that are not UTF-8"));
    // A missing byte, and half a character.
    for damaged in [&b"\xff\xfex\0y"[..], b"\xff\xfe\0\xd8x\0"] {
        assert!(read(damaged).unwrap_err().found.contains("damaged text in UTF-16"));
    }
    let mut long = b"x,y\n1,2\n".to_vec();
    long.resize(LONGEST_LINE + 100, b'7');
    assert_eq!(read(&long).unwrap_err().line, Some(3));
}

/// As Excel writes "Unicode text", and in the other byte order.
#[test]
fn text_in_utf16_is_read() {
    let text = "X_mm\tfwd_1_um\n801\t0,002\n781\t−0,779\n".replace('−', "-");
    for (mark, bytes) in [([0xff, 0xfe], u16::to_le_bytes as fn(u16) -> [u8; 2]), ([0xfe, 0xff], u16::to_be_bytes)] {
        let file: Vec<u8> = mark.into_iter().chain(text.encode_utf16().flat_map(bytes)).collect();
        assert_eq!(crate::text::decode(file.clone(), Path::new("t.csv"), &[]).unwrap(), text);
        let mut sheet = Sheet::new(&file[..], Path::new("t.csv")).unwrap();
        assert_eq!(sheet.header(), ["X_mm", "fwd_1_um"]);
        assert!(sheet.advance().unwrap());
        assert_eq!(sheet.dialect(), Some("read as tab separated with decimal commas"));
    }
}
