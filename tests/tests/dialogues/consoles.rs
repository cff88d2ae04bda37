//! Two consoles of one machine. They take turns, and either may wake the machine when the other has put it to sleep.

use std::cell::Cell;
use std::convert::Infallible;
use std::fmt::Write;
use std::rc::Rc;

use embassy_futures::block_on;
use embassy_time::{Duration, Instant};
use embedded_hal::digital::{ErrorType, OutputPin};
use isostep_controller::store::Kept;
use isostep_controller::{Controller, Error, FlowControl, Parameters, Settings, Store, config, least_times};
use isostep_motion::{Contact, Machine, coordinator};
use isostep_sim::Flash;
use isostep_sim::executor::Executor;
use isostep_sim::flash::FLASH_BYTES;
use isostep_sim::link::{Lines, Pipe};

const WELCOME: &str = "Grbl 1.1h ['$' for help]";
const ELSEWHERE: &str = "[MSG:Reset from elsewhere: all lines sent before are forgotten]";
const LOCKED: &str = "[MSG:'$H'|'$X' to unlock]";

/// An unconnected ENABLE output: nothing moves here.
struct Unconnected;

impl ErrorType for Unconnected {
    type Error = Infallible;
}

impl OutputPin for Unconnected {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A machine with consoles 0 and 1 and a boot loader.
struct Two {
    executor: Executor,
    controller: &'static Controller<'static, Flash>,
    links: [(Pipe, Pipe, Lines); 2],
    /// True if the machine may enter its boot loader.
    boots: Rc<Cell<bool>>,
}

impl Two {
    fn new(parameters: Parameters) -> Self {
        Self::with(parameters, |controller| controller)
    }

    /// With a controller that is changed by `change`.
    fn with(
        parameters: Parameters,
        change: impl FnOnce(Controller<'static, Flash>) -> Controller<'static, Flash>,
    ) -> Self {
        let mut executor = Executor::new();
        let settings = Settings::default();
        let machine: &'static Machine = Box::leak(Box::new(Machine::new(config(&settings), Contact::NormallyOpen)));
        let mut store = Store::new(Flash::blank(), 0..FLASH_BYTES as u32, settings);
        let kept = Kept { settings, parameters };
        assert_eq!(block_on(store.save(true, |item| kept.value(item))), Ok(()));
        let controller: &'static Controller<'static, _> =
            Box::leak(Box::new(change(Controller::new(machine, settings, store).with_boot_loader("DRIVE"))));
        block_on(controller.load());
        assert_eq!(controller.parameters(), kept.parameters);
        executor.spawn("coordinator", async move {
            let mut memory = coordinator::PlanMemory::new();
            coordinator::run(machine, &mut memory, &least_times::RP2040, Unconnected, |_| {}).await;
        });
        let boots = Rc::new(Cell::new(false));
        let asked = boots.clone();
        executor.spawn("boot", async move {
            controller.boot_asked().await;
            asked.set(true);
        });
        let links = ["console 0", "console 1"].map(|name| {
            let (rx, tx) = (Pipe::new(), Pipe::new());
            let (its_rx, its_tx) = (rx.clone(), tx.clone());
            executor.spawn(name, async move {
                let _ = controller.serve(its_rx, its_tx, FlowControl::Link).await;
            });
            (rx, tx, Lines::default())
        });
        Self { executor, controller, links, boots }
    }

    /// Sends to one console, and returns what each console answers.
    fn send(&mut self, console: usize, bytes: &[u8]) -> [Vec<String>; 2] {
        self.links[console].0.push(bytes);
        self.executor.run_until_quiescent(Instant::MAX).unwrap();
        self.links.each_mut().map(|(_, tx, lines)| lines.push(&tx.take()))
    }
}

fn heard(lines: &[&str]) -> Vec<String> {
    lines.iter().map(ToString::to_string).collect()
}

#[test]
fn the_startup_lines_run_once_after_power_up_however_many_consoles_there_are() {
    let mut parameters = Parameters::default();
    parameters.startup[1] = "G55".try_into().unwrap();
    parameters.coordinates.work_offsets_pm[1] = [1, 2, 3].map(|mm| mm * 1_000_000_000);
    let mut two = Two::new(parameters);
    assert_eq!(two.send(0, b""), [heard(&[WELCOME, ">G55:ok"]), heard(&[WELCOME])]);
    let [said, _] = two.send(0, b"$G\n$#\n");
    assert!(said[0].starts_with("[GC:G0 G55 ") && said[3] == "[G55:1.000,2.000,3.000]", "{said:?}");
    // A reset runs the start-up lines again, on the console that sent it.
    assert_eq!(two.send(1, b"\x18"), [heard(&[WELCOME, ELSEWHERE]), heard(&[WELCOME, ">G55:ok"])]);
}

#[test]
fn a_reset_on_one_console_wakes_what_another_has_put_to_sleep() {
    let mut two = Two::new(Parameters::default());
    two.send(0, b"");
    assert_eq!(two.send(0, b"$SLP\n"), [heard(&["ok", "[MSG:Sleeping]"]), heard(&[])]);
    assert_eq!(two.send(1, b"$G\n"), [heard(&[]), heard(&[])], "the sleeper keeps its turn");
    assert_eq!(two.send(1, b"\x18"), [heard(&[WELCOME, ELSEWHERE, LOCKED]), heard(&[WELCOME, LOCKED])]);
    assert_eq!(two.send(0, b"$X\n"), [heard(&["[MSG:Caution: Unlocked]", "ok"]), heard(&[])]);
    let [_, said] = two.send(1, b"$G\n");
    assert_eq!(said.len(), 2, "{said:?}");
}

#[test]
fn either_console_resumes_a_pause_and_lines_wait_for_it() {
    let mut two = Two::new(Parameters::default());
    two.send(0, b"");
    assert_eq!(two.send(0, b"M0\n"), [heard(&[]), heard(&[])]);
    assert_eq!(two.send(1, b"G21\n"), [heard(&[]), heard(&[])]);
    assert_eq!(two.send(1, b"~"), [heard(&["ok"]), heard(&["ok"])]);
    two.executor.run_for(Duration::from_secs(1)).unwrap();
    let [_, said] = two.send(1, b"?");
    assert!(said[0].starts_with("<Idle|"), "{said:?}");
}

const BOOTING: &str = "[MSG:The board becomes the USB drive DRIVE: copy new firmware to it, or switch off and on]";

#[test]
fn command_boot_makes_way_for_new_firmware() {
    let mut two = Two::new(Parameters::default());
    two.send(0, b"");
    assert_eq!(two.send(1, b"$110=1234\n"), [heard(&[]), heard(&["ok"])]);
    assert!(!two.boots.get());
    assert_eq!(two.send(0, b"$BOOT\nG21\n"), [heard(&[BOOTING, "ok", "error:8"]), heard(&[])]);
    assert!(two.boots.get());
    assert_eq!(two.send(1, b"$X\nG21\n$110=1\n"), [heard(&[]), heard(&["ok", "error:8", "error:8"])]);
    // A reset does not cancel it.
    let reported = heard(&[WELCOME, ELSEWHERE]);
    assert_eq!(two.send(0, b"\x18$X\nG21\n"), [heard(&[WELCOME, "ok", "error:8"]), reported]);
}

/// Counts the pages that it is asked for.
fn prove(words: &str, page: usize, text: &mut dyn Write) -> Result<bool, Error> {
    if words != "=3" {
        return Err(Error::BadNumber);
    }
    write!(text, "[PAGE:{page}]\r\n").map_err(|_| Error::BadNumber)?;
    Ok(page < 2)
}

#[test]
fn command_prove_prints_the_boards_pages_and_its_refusal() {
    let mut two = Two::with(Parameters::default(), |controller| controller.with_prove(prove));
    two.send(0, b"");
    let pages = heard(&["[PAGE:0]", "[PAGE:1]", "[PAGE:2]", "ok", "ok"]);
    assert_eq!(two.send(0, b"$prove = 3\nG21\n"), [pages, heard(&[])], "and the next line after all of them");
    assert_eq!(two.send(1, b"$PROVE\n"), [heard(&[]), heard(&["error:2"])]);
}

#[test]
fn command_prove_is_refused_by_a_board_that_does_not_measure_itself() {
    let mut two = Two::new(Parameters::default());
    two.send(0, b"");
    assert_eq!(two.send(0, b"$PROVE\n$PROVE=READ,0\n"), [heard(&["error:3", "error:3"]), heard(&[])]);
}

#[test]
fn a_machine_that_retires_ends_what_waits_and_begins_nothing() {
    for waiting in [&b"M0\n"[..], b"G4 P60\n", b"$SLP\n"] {
        let mut two = Two::new(Parameters::default());
        two.send(0, b"");
        two.links[0].0.push(waiting);
        two.links[1].0.push(b"G21\n$H\n$J=G91X1F100\n");
        two.executor.run_for(Duration::from_millis(20)).unwrap();
        let controller = two.controller;
        let retired = two.boots.clone();
        two.executor.spawn("retire", async move {
            controller.retire().await;
            retired.set(true);
        });
        two.executor.run_for(Duration::from_millis(20)).unwrap();
        assert!(two.boots.get(), "{waiting:?}");
        let [_, said] = two.send(1, b"?");
        assert!(said.last().unwrap().starts_with("<Sleep|"), "{waiting:?} {said:?}");
        assert!(said.contains(&ELSEWHERE.to_owned()), "{waiting:?} {said:?}");
        let [_, said] = two.send(1, b"G21\n$H\n$J=G91X1F100\n");
        assert_eq!(said, heard(&["error:8"; 3]), "{waiting:?}");
    }
}
