use super::Conditions;
use crate::compensation::{Direction, ThermalLine};
use crate::error::Fault;
use crate::step::tests::{PERIOD_NS, servo_loop, servo_loop_with};

#[test]
fn the_correction_at_a_command_is_what_the_step_settles_to() {
    let servo = servo_loop(1.0);
    let command = [55.0, 35.0, 25.0];
    let mut state = servo.start();
    state.set_thermal(0, ThermalLine::new(0.002, 1e-5).unwrap()).unwrap();
    let mut conditions = Conditions::default();
    conditions.thermal[0] = ThermalLine::new(0.002, 1e-5).unwrap();
    let mut sent = [0.0; 3];
    for _ in 0..3000 {
        sent = servo.step(&mut state, &servo.input(command, command), (), ()).record.correction;
    }
    let wanted = servo.correction_at(&command, &conditions).unwrap();
    assert!((0..3).all(|k| (sent[k] - wanted[k]).abs() < 1e-12), "{sent:?} {wanted:?}");
    let corrected: [f64; 3] = core::array::from_fn(|k| command[k] + wanted[k]);
    let error = servo.error_at(&corrected, &conditions).unwrap();
    assert!((0..3).all(|k| (corrected[k] + error[k] - command[k]).abs() < 1e-6 && error[k].abs() > 1e-3));
    assert_eq!(servo.pose_error_at(&corrected, &conditions).unwrap().tip.to_array(), error);
}

#[test]
fn positions_that_are_none_and_commands_beyond_the_travel_are_refused() {
    let (servo, forward) = (servo_loop(1.0), Conditions::default());
    for bad in [f64::NAN, f64::NEG_INFINITY, 1e12] {
        assert_eq!(servo.error_at(&[0.0, bad, 0.0], &forward), Err(Fault::CommandNotFinite));
        assert_eq!(servo.pose_error_at(&[0.0, bad, 0.0], &forward), Err(Fault::CommandNotFinite));
        assert_eq!(servo.correction_at(&[0.0, bad, 0.0], &forward), Err(Fault::CommandNotFinite));
    }
    assert_eq!(servo.correction_at(&[0.0, 110.001, 0.0], &forward), Err(Fault::CommandOutOfTravel));
    assert!(servo.correction_at(&[0.0, 110.0, -10.0], &forward).is_ok());
    // Beyond the table the error is that of its end.
    assert_eq!(servo.error_at(&[0.0, 150.0, 0.0], &forward), servo.error_at(&[0.0, 100.0, 0.0], &forward));
}

/// The half of a table is selected by a mask: one that covered only part of the bits would read outside it.
#[test]
fn negative_travel_reads_the_reverse_columns_and_the_backlash() {
    let servo = servo_loop_with::<f64, f64>(1.0, |axis| axis.backlash = 0.004);
    let forward = Conditions::default();
    assert_eq!(forward.directions, [Direction::POSITIVE; 3]);
    let reverse = Conditions { directions: [Direction::NEGATIVE; 3], ..forward };
    for position in [0.0, 35.0, 100.0] {
        let [there, back] = [forward, reverse].map(|at| servo.error_at(&[position; 3], &at).unwrap());
        assert!((0..3).all(|k| (back[k] - there[k] - 0.004).abs() < 1e-12), "{there:?} {back:?}");
    }
}

#[test]
fn an_input_of_the_loop_is_in_time_homed_and_enabled() {
    let input = servo_loop(1.0).input([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]);
    assert_eq!((input.elapsed_ns, input.homed, input.enable, input.reset), (PERIOD_NS, true, true, false));
    assert_eq!((input.command, input.feedback, input.encoder_alarm), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 0));
}
