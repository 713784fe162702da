//! Parameters, expressions, loops and subprograms: values and places worked out by hand, from LinuxCNC's documentation where a
//! case is its example. The comparison with LinuxCNC itself is in `firmware-sim`.

use trueaxis_sim::program::{Curve, Program, ProgramError, ReadOptions};
use trueaxis_testing::command::Folder;

fn parse(text: &str) -> Result<Program, ProgramError> {
    Program::parse("test", text, "part.ngc")
}

fn ends(program: &Program) -> Vec<[f64; 3]> {
    program.moves.iter().map(|m| m.curve.position(m.curve.domain().1)).collect()
}

/// X at the end of each move.
fn xs(text: &str) -> Vec<f64> {
    ends(&parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))).iter().map(|end| end[0]).collect()
}

fn assert_near(found: &[f64], expected: &[f64], text: &str) {
    let near = found.len() == expected.len() && found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-9);
    assert!(near, "{text}: {found:?} instead of {expected:?}");
}

#[test]
fn expressions_have_their_values() {
    let cases = [
        ("[1 + acos[0] - [0.5 ** [4.0/2]]]", 90.75),
        ("[2.0 / 3 * 1.5 - 5.5 / 11.0]", 0.5),
        ("[-2**2]", 4.0),
        ("[2**3**2]", 64.0),
        ("[10-3-2]", 5.0),
        ("[10 mod -3]", 1.0),
        ("[-7 MOD 3]", 2.0),
        ("[2+3*4**0.5]", 8.0),
        ("[1+2 GT 2 AND 1]", 1.0),
        ("[1 EQ 1.00005]", 1.0),
        ("[1 NE 1.0002]", 1.0),
        ("[1.00005 LE 1]", 0.0),
        ("[2 GE 3]", 0.0),
        ("[2 LT 3]", 1.0),
        ("[3 OR 0]", 1.0),
        ("[3 XOR 4]", 0.0),
        ("[3 AND 0]", 0.0),
        ("atan[1]/[-1]", 135.0),
        ("fix[-2.8]", -3.0),
        ("fup[-2.8]", -2.0),
        ("round[-2.5]", -3.0),
        ("abs[-3.5]", 3.5),
        ("sin[30]", 0.5),
        ("cos[60]", 0.5),
        ("tan[45]", 1.0),
        ("asin[0.5]", 30.0),
        ("sqrt[2]", std::f64::consts::SQRT_2),
        ("exp[1]", std::f64::consts::E),
        ("ln[exp[2]]", 2.0),
        ("-[2]", -2.0),
        ("- - 2", 2.0),
        ("[+2--3]", 5.0),
        ("[exists[#<_none>] + exists[#5]]", 1.0),
    ];
    for (expression, value) in cases {
        assert_near(&xs(&format!("G0 X50\nX {expression}")), &[50.0, value], expression);
    }
}

#[test]
fn an_assignment_counts_from_the_next_line() {
    assert_near(&xs("#3=15\n#3=6 G0 X#3\nX#3"), &[15.0, 6.0], "");
    assert_near(&xs("#1=2 #2=9\n#[#1+1]=7\nG0 X#3\nX##1\n#<a B>=4 #<_g>=5\nX-#<ab> Y#<_G>"), &[7.0, 9.0, -4.0], "");
}

#[test]
fn the_state_is_read() {
    // G55 is at X 25.4, Y −25.4; the last place is X 50.8 of it, then X 0 of G54.
    let text = "G20 G90 G55 G10 L2 P2 X1 Y-1\nG0 X2 Y3\nG91 F7 S8 M4\nG21\nG90 G54 G0 X0\n";
    let names = [
        ("#5420", 0.0),
        ("#5421", 50.8),
        ("#<_y>", 50.8),
        ("#<_abs_y>", 50.8),
        ("#5021", 0.0),
        ("#5241", 25.4),
        ("#5220", 1.0),
        ("#<_coord_system>", 540.0),
        ("#<_metric>", 1.0),
        ("#<_incremental>", 0.0),
        ("#<_feed>", 7.0),
        ("#<_rpm>", 8.0),
        ("#<_spindle_cw>", 0.0),
        ("#<_spindle_on>", 1.0),
        ("#<_plane>", 170.0),
        ("#<_motion_mode>", 0.0),
        ("#<_line>", 6.0),
        ("#<_call_level>", 0.0),
        ("#<_selected_tool>", 0.0),
    ];
    for (name, value) in names {
        let last = ends(&parse(&format!("{text}X[{name}+0.5]")).unwrap()).pop().unwrap()[0];
        assert!((last - value - 0.5).abs() < 1e-9, "{name}: {last}");
    }
}

#[test]
fn loops_and_conditions() {
    // The sawtooth, the do loop and the condition of LinuxCNC's documentation.
    let text = "G0 X1 Y0\n#1=0\nF25\no101 while [#1 LT 10]\nG1 X0\nG1 Y[#1/10] X1\n#1=[#1+1]\no101 endwhile\nM2\n";
    let saw = ends(&parse(text).unwrap());
    assert_eq!(saw.len(), 21);
    assert_eq!(saw[20], [1.0, 0.9, 0.0]);
    let text = "#1=0\no100 do\nG0 X[#1+1]\no110 if [#1 EQ 2]\n#1=3\no100 continue\no110 endif\nX-1\n#1=[#1+1]\no100 while [#1 LT 3]\nX9";
    assert_near(&xs(text), &[1.0, -1.0, 2.0, -1.0, 3.0, 9.0], text);
    for (value, expected) in [(6.0, 100.0), (1.0, 20.0), (3.0, 200.0)] {
        let text = format!(
            "#2={value}\no102 if [#2 GT 5]\nG0 X100\no102 elseif [#2 LT 2]\nG0 X20\no102 else\nG0 X200\no102 endif\nX1"
        );
        assert_near(&xs(&text), &[expected, 1.0], &text);
    }
    let text = "#1=0\no1 while [1]\n#1=[#1+1]\no2 if [#1 LE 2]\no1 continue\no2 endif\no3 if [#1 GT 4]\no1 break\no3 endif\nG0 X#1\no1 endwhile\nX9";
    assert_near(&xs(text), &[3.0, 4.0, 9.0], text);
    let text =
        "G91\no1 repeat [2.5]\no2 repeat [3]\nG0 X1\no2 endrepeat\no1 endrepeat\no3 repeat [0.4]\nX100\no3 endrepeat";
    assert_eq!(xs(text).len(), 6);
    // The branches that are not taken are not evaluated, and may have any text.
    assert_near(&xs("o1 if [0]\nG999 X#<a> (open\no2 if [1/0]\no2 endif\no1 else\nG0 X1\no1 endif"), &[1.0], "");
}

#[test]
fn subprograms_have_their_own_parameters() {
    let text = "o100 sub\n#<a>=5\nG0 X#1 Y#2 Z#3\n#1=50\n#31=[#31+1]\no110 if [#1 GT 40]\no100 return [#31*2]\no110 endif\nG0 X-1\no100 endsub\n\
                #1=7 #2=8 #<a>=1\no100 call [1] [2]\nG0 X#1 Y#2 Z[#<_value>+#<_value_returned>]\no100 call\nG0 X[#31+#<a>]";
    let found = ends(&parse(text).unwrap());
    assert_eq!(found, [[1.0, 2.0, 0.0], [7.0, 8.0, 3.0], [0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    // Fanuc's: #1 is shared, in LinuxCNC's example it ends at 5.25.
    let text = "o1\n#1=0\nM98 P100 L5\nG0 X#1\nM30\no100\n#1=[#1+1]\nM98 P200 L5\nM99\no200\n#1=[#1+0.01]\nM99\n%";
    assert_near(&xs(text), &[5.25], text);
    assert_near(&xs("M98 P7 L0\nG0 X1\nM30\nO7\nX100\nM99"), &[1.0], "");
    // A recursion, defined after its call.
    let text =
        "o<fall> call [5]\nM2\no<fall> sub\no1 if [#1 GT 0]\nG0 X#1\no<fall> call [#1-1]\no1 endif\no<fall> endsub";
    assert_near(&xs(text), &[5.0, 4.0, 3.0, 2.0, 1.0], text);
    // A label may be computed.
    assert_near(
        &xs("o5 sub\nG0 X5\no5 endsub\no6 sub\nG0 X6\no6 endsub\n#1=5\no[#1+1] call\no#1 call"),
        &[6.0, 5.0],
        "",
    );
}

#[test]
fn modes_are_saved() {
    let text =
        "G21 G90 G17 F200\no100 sub\nM73\nG20 G91 F5\nG1 X1\no100 endsub\no100 call\nG1 X2\nM70\nG91 G20\nM72\nX1";
    let program = parse(text).unwrap();
    assert_near(&ends(&program).iter().map(|end| end[0]).collect::<Vec<_>>(), &[25.4, 2.0, 1.0], text);
    let feeds: Vec<f64> = program.moves.iter().map(|m| m.feed_per_min).collect();
    // F is in the unit before the line.
    assert_eq!(feeds, [5.0, 200.0, 200.0]);
}

#[test]
fn polar_words_splines_and_diameters() {
    let root = 0.5_f64.sqrt();
    let found = ends(&parse("G0 @3^45\nG91 @1\n^45\nG90 ^0\n@2\nG17 G7 X10\nG8 X3").unwrap());
    let expected = [[3.0 * root; 2], [4.0 * root; 2], [0.0, 4.0], [4.0, 0.0], [2.0, 0.0], [5.0, 0.0], [3.0, 0.0]];
    for (found, expected) in found.iter().zip(expected) {
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{found:?} instead of {expected:?}");
    }
    // Bézier curves: the middle is (P0 + 3 P1 + 3 P2 + P3) / 8 and (P0 + 2 P1 + P2) / 4.
    let program = parse("F9 G0 X1 Y1\nG5 I0 J3 P0 Q-3 X2 Y2\nG5 P0 Q-3 X3 Y2\nG5.1 X13 I5 J-15").unwrap();
    let middles = [[1.5, 1.5], [2.5, 2.0], [8.0, -5.5]];
    for (element, middle) in program.moves.iter().skip(1).zip(middles) {
        assert!(matches!(element.curve, Curve::Nurbs { .. }));
        let at = element.curve.position(0.5);
        assert!((0..2).all(|k| (at[k] - middle[k]).abs() < 1e-12), "{at:?} instead of {middle:?}");
    }
}

#[test]
fn what_posts_write_is_accepted_where_it_has_one_meaning() {
    let program = parse("F200 G2 X10 Y0 Z-1.5 I5 J0 K0.000\nG1 X0\nG0 G91 G28 Z0.\nG90 X1").unwrap();
    assert_eq!(program.moves.last().map(|m| m.rapid), Some(true));
    let program = parse("F100 G0 Z5\nG98 G81 X5 Y5 Z-2 R1\nG80\nZ15.\nM67 E0 Q0.5\nG1 Y SQRT[2] F9991300").unwrap();
    let [.., up, last] = program.moves.as_slice() else { panic!() };
    assert!(up.rapid && up.curve.position(1.0)[2] == 15.0);
    assert_eq!((last.curve.position(1.0)[1], last.feed_per_min), (2.0_f64.sqrt(), 1.0e6));
    assert!(program.notes.iter().any(|note| note.word == "F above 1e6" && note.count == 1));
    // After a line at the feed it could be either.
    let error = parse("F100 G1 Z5\nG81 X5 Z-2 R1\nG80\nZ15").unwrap_err();
    assert_eq!((error.line, error.found.as_str()), (4, "`Z15`"));
}

#[test]
fn a_loop_without_an_end_is_refused_with_its_line() {
    let read = |text: &str| Program::read_within("p", text.as_bytes(), "part.ngc", &ReadOptions::default(), 1000);
    let cases = [
        ("#1=1\no1 while [#1]\no2 repeat [3]\n#2=[#2+1]\no2 endrepeat\no1 endwhile", 2, "after 5001 lines"),
        ("o1 do\nG91 G0 X0.001\no1 while [1]", 1, "1001 pieces"),
        ("o1 sub\no2 repeat [2]\no3 while [1]\no3 endwhile\no2 endrepeat\no1 endsub\no1 call", 3, "lines"),
        ("G0 X1\nM98 P7 L900000\nM2\nO7\nM99", 2, "lines"),
        ("o1 sub\no1 call\no1 endsub\no1 call", 2, "10 subprograms within"),
    ];
    for (text, line, found) in cases {
        let error = read(text).expect_err(text);
        assert_eq!(error.line, line, "{text}: {error}");
        assert!(error.found.contains(found), "{text}: {error}");
    }
    // A long loop that ends is none.
    assert!(read("o1 repeat [2000]\n#1=[#1+1]\no1 endrepeat\nG0 X#1").is_ok());
}

#[test]
fn refusals_name_line_and_word() {
    let cases = [
        ("G0 X[1/0]", 1, "1 / 0", "finite"),
        ("G0 X[0 MOD 0]", 1, "0 MOD 0", "finite"),
        ("G0 X sqrt[-1]", 1, "SQRT of -1", "finite"),
        ("G0 X acos[2]", 1, "ACOS of 2", "finite"),
        ("G0 X ln[0]", 1, "LN of 0", "finite"),
        ("G0 X foo[1]", 1, "`FOO[1]`", "SQRT"),
        ("G0 X[2 3 ^ 4]", 1, "^4]", "operator"),
        ("G0 X atan[1]", 1, "ATAN[1]", "ATAN[y]/[x]"),
        ("G0 X#5603", 1, "`#5603`", "#5602"),
        ("G0 X#1.5", 1, "1.5", "whole"),
        ("#5420=1", 1, "#5420", "assigned"),
        ("#<_x>=1", 1, "#<_X>", "assigned"),
        ("#5220=2", 1, "#5220", "G54"),
        ("G0 X#<a", 1, "<A", "name in < >"),
        ("o1 if [1]\nG0 X1", 1, "O word without its end", "endif"),
        ("o1 if [0]\nG0 X1", 1, "`O1 if` without its end", "O1 endif"),
        ("o1 endif", 1, "O1 endif", "O1 if before it"),
        ("o1 do\no2 break", 2, "O2 break", "O2 while or O2 do or O2 repeat"),
        ("o1 while", 1, "``", "expression in [ ]"),
        ("o1 do [1]", 1, "`[1]` after an O word", "separate line"),
        ("o1 endsub", 1, "outside a subprogram", "O1 sub"),
        ("o1 call", 1, "`O1 call` without its subprogram", "O1 sub"),
        ("o1 sub\no2 sub\no2 endsub\no1 endsub\no1 call", 2, "O2 sub", "endsub"),
        ("o1 sub\nM99\no1 endsub\no1 call", 2, "M99", "endsub"),
        ("o1 sub\nG0 X1\no1 endsub\nM98 P1", 4, "M98 P1", "O1"),
        ("M98 P1\nM2\nO1\nG0 X1", 4, "end of the file in the subprogram called in line 1", "M99"),
        ("G0 @3 X1", 1, "`@3`", "with @ and ^"),
        ("G0 @3", 1, "`@3`", "with @ and ^"),
        ("F1 G5 X1 Y1 P1 Q1", 1, "without I and J", "direction"),
        ("F1 G5 X1 Y1 I1 J1 P1", 1, "one of P and Q", "both"),
        ("F1 G18 G5.1 X1 I1 J1", 1, "G18", "G17"),
    ];
    for (text, line, found, needed) in cases {
        let error = parse(text).expect_err(text);
        assert_eq!((error.line, error.file.as_str()), (line, "part.ngc"), "{text}: {error}");
        assert!(error.found.contains(found) && error.needed.contains(needed), "{text}: {error}");
    }
    // Deep brackets end in a refusal, not in the stack.
    assert!(parse(&format!("G0 X{}", "[".repeat(1_000_000))).unwrap_err().needed.contains("at most 100"));
    assert!(parse(&format!("G0 X{}1", "#".repeat(1_000_000))).unwrap_err().needed.contains("at most 100"));
    let open = "o1 do\n".repeat(300);
    assert_eq!(parse(&open).unwrap_err().line, 201);
}

#[test]
fn another_control_s_language_is_named() {
    let error = parse("0 BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-10\n").unwrap_err();
    assert_eq!((error.line, error.found.as_str()), (1, "`0 BEGIN PGM PART MM`, the beginning of a Heidenhain program"));
    let siemens = |file: &str, text: &str| Program::parse("p", text, file).unwrap_err();
    assert!(siemens("part.mpf", "N10 G54\nN20 R1=5\n").found.ends_with("in a program in Siemens' language"));
    assert!(siemens("part.nc", "G0 X0\nCYCLE81(5,0,1,-3)\n").needed.contains("G-code"));
    assert!(!siemens("part.nc", "G0 X0\nFOO\n").found.contains("Siemens"));
}

#[test]
fn subprograms_come_from_the_folder() {
    let folder = Folder::new("");
    folder.write("square.ngc", "%\no<square> sub\nG91 G0 X#1\nY#1\nG90\no<square> endsub [#1*2]\n%\n");
    folder.write("bad.ngc", "o<bad> sub\n\nG0 X#<none>\no<bad> endsub\n");
    folder.write("empty.ngc", "(nothing)\n");
    let options = ReadOptions::default().beside(&folder.join("part.ngc"));
    let read = |text: &str| Program::read("p", text.as_bytes(), "part.ngc", &options);
    let program = read("G0 X1\no<Square> call [2]\nG0 Z#<_value>\no<square> call [3]").unwrap();
    assert_eq!(
        ends(&program),
        [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 2.0, 0.0], [3.0, 2.0, 4.0], [6.0, 2.0, 4.0], [6.0, 5.0, 4.0]]
    );
    // Its moves have the line of the call; its errors their own file and line.
    assert_eq!(program.moves.iter().map(|m| m.line).collect::<Vec<_>>(), [1, 2, 2, 3, 4, 4]);
    let error = read("G0 X1\no<bad> call").unwrap_err();
    assert!(error.file.ends_with("bad.ngc") && error.line == 3, "{error}");
    let error = read("o<empty> call").unwrap_err();
    assert!(error.needed.contains("a file empty.ngc with it in its folder"), "{error}");
    assert!(read("o<../square> call [1]").is_err());
    assert!(parse("o<square> call [1]").is_err());

    // The same files as texts.
    let texts = ["square.ngc", "bad.ngc", "empty.ngc"].map(|name| (name.to_owned(), folder.read(name)));
    let options = ReadOptions { texts: Some(texts.into()), ..ReadOptions::default() };
    let read = |text: &str| Program::read("p", text.as_bytes(), "part.ngc", &options);
    assert_eq!(ends(&read("o<Square> call [2]").unwrap()), [[2.0, 0.0, 0.0], [2.0, 2.0, 0.0]]);
    let error = read("G0 X1\no<bad> call").unwrap_err();
    assert_eq!((error.file.as_str(), error.line), ("bad.ngc", 3));
    let error = read("o<none> call").unwrap_err();
    assert!(error.needed.ends_with("a file none.ngc with it beside the program"), "{error}");
}
