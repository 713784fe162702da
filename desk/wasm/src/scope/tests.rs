//! Scopes as used by the page, except for the JavaScript interface.

use super::*;
use serde_json::{Value, json};

/// Files of a sample machine.
fn sample(name: &str) -> Value {
    serde_json::to_value(crate::samples::sample(name).unwrap()).unwrap()
}

const PROGRAM: &str = "G21 G90 F1500\nG1 X10\nG2 X10 Y-20 J-10\nG1 X0 Y0\nG0 Z5\n";

fn request(settings: &str) -> Value {
    let program = json!({ "name": "loop.ngc", "text": PROGRAM });
    json!({ "machine": sample("mill-3axis"), "program": program, "settings": settings })
}

fn open(request: &Value) -> u32 {
    opened(&request.to_string()).unwrap()
}

fn figures(scope: u32) -> Value {
    with(scope, |session| Ok(serde_json::to_value(session.figures())?)).unwrap()
}

fn finish(scope: u32) -> Value {
    while !with(scope, |session| Ok(serde_json::to_value(session.advance(777))?)).unwrap()["done"].as_bool().unwrap() {}
    figures(scope)
}

#[test]
fn two_scopes_run_side_by_side_and_are_closed() {
    let (a, b) = (open(&request("rate_hz = 1000")), open(&request("rate_hz = 1000\nseed = 2")));
    let (first, second) = (finish(a), finish(b));
    assert_ne!(first["digest"]["compensated"], second["digest"]["compensated"]);
    scope_close(a);
    assert_eq!(with(a, |_| Ok(())).unwrap_err().to_string(), format!("scope {a}: found closed, needed open"));
    assert_eq!(figures(b), second);
}

#[test]
fn rows_have_their_columns_and_the_largest_error() {
    let scope = open(&request("rate_hz = 1000"));
    let figures = finish(scope);
    with(scope, |session| {
        let (names, rows) = (session.traces.names(), session.traces.rows());
        assert_eq!(rows.len() % names.len(), 0);
        assert!(rows.len() / names.len() > 200 && rows.len() / names.len() < 5000, "{}", rows.len());
        let column = |name: &str| names.iter().position(|known| known == name).unwrap();
        let (error, cutting) = (column("compensated.error_um"), column("cutting"));
        let cut = rows.chunks(names.len()).filter(|row| row[cutting] == 1.0).map(|row| row[error]);
        let largest = cut.fold(0.0, f64::max);
        let reported = figures["contour_error_um"]["compensated"]["max"].as_f64().unwrap();
        assert!((largest - reported).abs() < 1e-6 * reported, "{largest} {reported}");
        assert!(rows.chunks(names.len()).is_sorted_by(|a, b| a[1] < b[1]));
        let path = session.path();
        assert_eq!(path.chunks(5).map(|point| point[3] as u32).max(), Some(5));
        Ok(())
    })
    .unwrap();
}

#[test]
fn manual_acts_enter_the_scenario_which_reproduces_them() {
    let mut machine = request("rate_hz = 1000");
    machine["kinds"] = json!(["uncompensated", "compensated", "full"]);
    let mut warm = sample("mill-3axis");
    let text = warm["machine.toml"].as_str().unwrap().replacen("C0Y_urad = 38.0", "C0Y_urad = 60.0", 1);
    assert!(warm["machine.toml"] != text.as_str());
    warm["machine.toml"] = text.into();
    let scope = open(&machine);
    with(scope, |session| {
        session.advance(300);
        session.act("glitch:Y@now+1=5mm")?;
        session.advance(101);
        session.act("off:correction@now")?;
        session.advance(99);
        session.act(&json!({ "act": "on:correction@now" }).to_string())?;
        session.act("off:friction@now")?;
        session.advance(300);
        let recorded = session.act(&json!({ "act": "exchange:warm@now", "files": warm }).to_string())?;
        let expected = json!({ "list": "events", "act": "exchange:warm@0.8s", "time_s": 0.8 });
        assert_eq!(serde_json::to_value(recorded)?, expected);
        Ok(())
    })
    .unwrap();
    let by_hand = finish(scope);
    let again = with(scope, |session| Ok(serde_json::to_value(session.reproduction()?)?)).unwrap();
    let expected = "firmware-sim run --machine machine --program loop.ngc --scenario scenario.toml";
    assert_eq!(again["command"], expected);
    let files = again["files"].as_object().unwrap();
    for file in ["machine/machine.toml", "machine/x.csv", "warm/machine.toml", "loop.ngc", "scenario.toml"] {
        assert!(files.contains_key(file), "{file}");
    }
    machine["settings"] = again["toml"].clone();
    machine["exchanges"] = json!({ "warm": warm });
    assert_eq!(finish(open(&machine)), by_hand);
    machine["settings"] = "rate_hz = 1000".into();
    let plain = finish(open(&machine));
    for kind in ["compensated", "full"] {
        assert_ne!(plain["digest"][kind], by_hand["digest"][kind]);
    }
    assert_eq!(by_hand["faults"].as_array().unwrap().len(), 1);
}

#[test]
fn refusals_say_what_is_needed_and_change_nothing() {
    let refused = |change: &dyn Fn(&mut Value), expected: &str| {
        let mut bad = request("rate_hz = 1000");
        change(&mut bad);
        let error = format!("{:#}", opened(&bad.to_string()).unwrap_err());
        assert!(error.contains(expected), "{error}\nneeded {expected}");
    };
    refused(&|r| r["settings"] = "rate_hz = 1".into(), "scenario.toml:1: rate_hz: found 1, needed 100 to 100000 Hz");
    refused(&|r| r["program"] = json!({ "builtin": "sphere" }), "no shipped program \"sphere\"");
    refused(&|r| r["program"]["text"] = "G1 X10\nG1 Q\n".into(), "loop.ngc");
    refused(&|r| r["program"]["name"] = "../loop.ngc".into(), "needed a plain file name");
    refused(&|r| r["kinds"] = json!(["perfect"]), "kinds: found \"perfect\", needed some of uncompensated");
    refused(&|r| r["orientation"] = true.into(), "found on with the nine-term model");
    refused(
        &|r| r["settings"] = "events = [\"exchange:warm@1s\"]".into(),
        "exchange:warm: found no machine of that name",
    );
    refused(&|r| r["machine"]["x.csv"] = "nonsense".into(), "x.csv");

    let scope = open(&request("rate_hz = 1000"));
    with(scope, |session| {
        session.advance(500);
        for (act, expected) in [
            ("off:correction@0.1s", "needed a time from 0.5 s on"),
            ("off:brakes@now", "needed correction, friction"),
            ("dropout:C@now+1", "found axis C, needed one of the machine's axes"),
            ("exchange:warm@now", "found no machine of that name"),
            ("glitch:Y@now", "needed TIMEs+CYCLES"),
        ] {
            let error = session.act(act).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}\nneeded {expected}");
        }
        let five = json!({ "act": "exchange:five@now", "files": sample("mill-5axis") });
        let error = session.act(&five.to_string()).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("axes XYZAC, needed XYZ"), "{error}");
        assert_eq!(session.settings, session.scenario.settings);
        Ok(())
    })
    .unwrap();
    assert_eq!(finish(scope), finish(open(&request("rate_hz = 1000"))));
    let ended = with(scope, |session| session.act("off:lag@now").map(|_| ())).unwrap_err().to_string();
    assert!(ended.contains("found a run that has ended"), "{ended}");
}
