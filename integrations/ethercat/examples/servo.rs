//! Three CSP drives on a network, with distributed clocks: `cargo run --release --example servo -- eth0 machine.tcomp`.
//!
//! The drives' process data must be mapped as in `IMAGE_BYTES` (in their EEPROM or as fixed PDOs). The example sets
//! their mode to cyclic synchronous position (0x6060 = 8). The command moves X back and forth by 1 mm from the drives'
//! position.

use std::time::{Duration, Instant};

use ethercrab::error::Error;
use ethercrab::std::{ethercat_now, tx_rx_task};
use ethercrab::subdevice_group::DcConfiguration;
use ethercrab::{DcSync, MainDevice, MainDeviceConfig, PduStorage, Timeouts};
use trueaxis::{Fault, HostServo};
use trueaxis_ethercat::{AXES, Cycle, Frame, IMAGE_BYTES, PERIOD_NS, tables};

const COUNTS_PER_MM: f64 = 100_000.0;
const PERIOD: Duration = Duration::from_nanos(PERIOD_NS as u64);

static STORAGE: PduStorage<16, { PduStorage::element_size(1100) }> = PduStorage::new();

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(interface), Some(path)) = (arguments.next(), arguments.next()) else {
        return Err("usage: servo INTERFACE MACHINE.tcomp".into());
    };
    // Check everything that may be refused before the first access to the network.
    let bytes = std::fs::read(path)?;
    let file = tables(&bytes).inspect_err(|line| eprintln!("{line}")).ok();
    let mut memory = vec![0.0; file.as_ref().map_or(0, |file| file.requirement())];
    let servo = file.and_then(|file| {
        HostServo::<AXES>::load(&file, PERIOD_NS, &mut memory)
            .inspect_err(|error| eprintln!("trueaxis: {error}; running uncompensated"))
            .ok()
    });
    let mut cycle = match &servo {
        Some(servo) => Cycle::new(servo, COUNTS_PER_MM),
        None => Cycle::uncompensated(Fault::TablesRefused, COUNTS_PER_MM),
    };
    smol::block_on(run(&interface, &mut cycle))?;
    Ok(())
}

async fn run(interface: &str, cycle: &mut Cycle<'_>) -> Result<(), Error> {
    let (tx, rx, pdu_loop) = STORAGE.try_split().expect("split once");
    let network = tx_rx_task(interface, tx, rx).unwrap_or_else(|error| panic!("{interface}: {error}"));
    smol::spawn(network).detach();
    // A frame that does not return within half a cycle counts as lost. It is not sent again.
    let timeouts = Timeouts { pdu: PERIOD / 2, ..Timeouts::default() };
    let main_device = MainDevice::new(pdu_loop, timeouts, MainDeviceConfig::default());

    let mut group = main_device.init_single_group::<4, 64>(ethercat_now).await?;
    if group.len() != AXES {
        panic!("found {} devices, needed {AXES} drives", group.len());
    }
    for mut drive in group.iter_mut(&main_device) {
        drive.sdo_write(0x6060, 0, 8i8).await?;
        drive.set_dc_sync(DcSync::Sync0);
    }
    let group = group.into_pre_op_pdi(&main_device).await?;
    // Wait until the drives' clocks are synchronised.
    for _ in 0..5000 {
        group.tx_rx_sync_system_time(&main_device).await?;
        smol::Timer::after(PERIOD).await;
    }
    let clocks =
        DcConfiguration { start_delay: Duration::from_millis(100), sync0_period: PERIOD, sync0_shift: PERIOD / 2 };
    let group = group.configure_dc_sync(&main_device, clocks).await?;
    let group = group.into_safe_op(&main_device).await?;
    let group = group.request_into_op(&main_device).await?;

    let mut inputs = [[0; IMAGE_BYTES]; AXES];
    let mut outputs = [[0; IMAGE_BYTES]; AXES];
    let (mut start, mut n, mut printed) = (None, 0_u32, None);
    loop {
        let began = Instant::now();
        let mut wait = PERIOD;
        let frame = match group.tx_rx_dc(&main_device).await {
            Ok(response) => {
                wait = response.extra.next_cycle_wait;
                // A drive counts 1 for the data read from it and 2 for the data written to it.
                if response.working_counter as usize == 3 * AXES && response.all_op() {
                    Frame::Received { system_time_ns: response.extra.dc_system_time }
                } else {
                    Frame::Lost
                }
            }
            Err(_) => Frame::Lost,
        };
        // A missing frame counts as lost only once the drives are in operation.
        let started = start.is_some() || matches!(frame, Frame::Received { .. });
        if started {
            for (drive, image) in group.iter(&main_device).zip(&mut inputs) {
                image.copy_from_slice(&drive.inputs_raw()[..IMAGE_BYTES]);
            }
            let [x, y, z] = *start.get_or_insert_with(|| position(&inputs));
            let command = [x + 0.5 - 0.5 * (f64::from(n) * 0.001).cos(), y, z];
            let report = cycle.run(frame, &inputs, command, &mut outputs);
            n = if report.running { n + 1 } else { 0 };
            if !report.running && report.stop.is_none() {
                start = Some(cycle.position());
            }
            for (drive, image) in group.iter(&main_device).zip(&outputs) {
                drive.outputs_raw_mut()[..IMAGE_BYTES].copy_from_slice(image);
            }
            let now = (report.stop, report.output.record.fault);
            if printed != Some(now) {
                eprintln!("cycle {n}: stop {:?}, {}", now.0, now.1);
                printed = Some(now);
            }
        }
        smol::Timer::at(began + wait).await;
    }
}

fn position(inputs: &[[u8; IMAGE_BYTES]; AXES]) -> [f64; AXES] {
    inputs.map(|[_, _, a, b, c, d]| f64::from(i32::from_le_bytes([a, b, c, d])) / COUNTS_PER_MM)
}
