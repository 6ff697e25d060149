// SPDX-License-Identifier: Apache-2.0
// ethercrab, unmodified, as a master of sim.bus.master_loop: slaves to OP with distributed clocks, then one cycle
// for each line of standard input.
//
// A line in is a number, the byte that all outputs get; a line out is the working counter and the inputs of each slave in
// hexadecimal. The first line out is the number of slaves, once all are in OP. Errors go to standard error, status 1.
use ethercrab::std::{ethercat_now, tx_rx_task};
use ethercrab::{MainDevice, MainDeviceConfig, PduStorage, Timeouts};
use std::error::Error;
use std::io::{BufRead, Write};
use std::time::Duration;

const SLAVES: usize = 16;
const PROCESS_BYTES: usize = 4096;
const CLOCK_FRAMES: u32 = 100; // before the first cycle

static STORAGE: PduStorage<16, { PduStorage::element_size(1100) }> = PduStorage::new();

// Simulated wires on a loaded machine are slow.
fn timeouts() -> Timeouts {
    Timeouts {
        state_transition: Duration::from_secs(120),
        pdu: Duration::from_secs(10),
        eeprom: Duration::from_secs(10),
        wait_loop_delay: Duration::from_millis(1),
        mailbox_echo: Duration::from_secs(10),
        mailbox_response: Duration::from_secs(10),
    }
}

async fn run(interface: &str) -> Result<(), Box<dyn Error>> {
    let (tx, rx, loop_) = STORAGE.try_split().map_err(|()| "the storage is split already")?;
    let config = MainDeviceConfig {
        dc_static_sync_iterations: CLOCK_FRAMES,
        ..Default::default()
    };
    let main_device = MainDevice::new(loop_, timeouts(), config);
    smol::spawn(tx_rx_task(interface, tx, rx)?).detach();
    let group = main_device
        .init_single_group::<SLAVES, PROCESS_BYTES>(ethercat_now)
        .await?;
    let group = group.into_op(&main_device).await?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}", group.len())?;
    out.flush()?;
    for line in std::io::stdin().lock().lines() {
        let value: u8 = line?.trim().parse()?;
        for slave in group.iter(&main_device) {
            slave.outputs_raw_mut().fill(value);
        }
        let response = group.tx_rx(&main_device).await?;
        write!(out, "{}", response.working_counter)?;
        for slave in group.iter(&main_device) {
            write!(out, " ")?;
            for byte in slave.inputs_raw().iter() {
                write!(out, "{byte:02x}")?;
            }
        }
        writeln!(out)?;
        out.flush()?;
    }
    Ok(())
}

fn main() {
    let interface = std::env::args().nth(1).unwrap_or_else(|| "ec0".into());
    if let Err(error) = smol::block_on(run(&interface)) {
        eprintln!("error: {error}");
        std::process::exit(1);
    }
}
