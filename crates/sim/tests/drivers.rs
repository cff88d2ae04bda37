//! Four TMC2209s on a wire, asked and told by the datagrams of another's crate.

use isostep_sim::drivers::{DriverFault, Wire};
use tmc2209::reg::*;
use tmc2209::{ReadRequest, ReadResponse, ReadableRegister, Reader, WritableRegister, WriteRequest};

/// X, Y, Z and a fourth motor of a BIGTREETECH SKR Pico.
const ADDRESSES: [u8; 4] = [0, 2, 1, 3];
/// Speed at which `SG_RESULT` is measured whatever the pins say, and its `TSTEP` at 8 microsteps.
const FAST_STEPS_S: f64 = 4_000.0;
const FAST_TSTEP: u32 = 93;

fn wire() -> Wire {
    Wire::new(ADDRESSES)
}

/// A motor turns at this speed with this load for four full steps.
fn turn(wire: &mut Wire, driver: usize, speed_steps_s: f64, load: f64) {
    wire[driver].set_load(speed_steps_s, load);
    let full_steps = 4 * i32::from(wire[driver].microsteps());
    wire[driver].step(full_steps);
}

/// The bytes that are heard after the echo.
fn after_echo(wire: &mut Wire, sent: &[u8]) -> Vec<u8> {
    let heard = wire.exchange(sent);
    heard.strip_prefix(sent).expect("the echo comes first").to_vec()
}

fn response(bytes: &[u8]) -> Option<ReadResponse> {
    let (_, response) = Reader::default().read_response(bytes);
    response.filter(ReadResponse::crc_is_valid)
}

fn ask<R: ReadableRegister>(wire: &mut Wire, driver: usize) -> Option<R> {
    let bytes = after_echo(wire, ReadRequest::new::<R>(ADDRESSES[driver]).bytes());
    response(&bytes)?.register().ok()
}

fn get<R: ReadableRegister>(wire: &mut Wire, driver: usize) -> R {
    ask(wire, driver).expect("a reply")
}

fn set<R: WritableRegister>(wire: &mut Wire, driver: usize, register: R) {
    let bytes = after_echo(wire, WriteRequest::new(ADDRESSES[driver], register).bytes());
    assert_eq!(bytes, [], "a write has no reply");
}

/// The value that a read of this register gives.
fn number(wire: &mut Wire, driver: usize, register: Address) -> u32 {
    let bytes = after_echo(wire, ReadRequest::from_addr(ADDRESSES[driver], register).bytes());
    let response = response(&bytes).expect("a reply");
    assert_eq!(response.reg_addr().unwrap(), register);
    response.data_u32()
}

#[test]
fn every_register_is_kept_or_hidden_as_the_data_sheet_says() {
    let pattern = 0x9ABC_DEF5;
    for (driver, node) in ADDRESSES.into_iter().enumerate() {
        for &address in Address::ALL {
            let mut wire = wire();
            let before = number(&mut wire, driver, address);
            wire.exchange(WriteRequest::from_raw_data(node, address, pattern).bytes());
            let after = match address {
                Address::GCONF => pattern & 0x3FF,
                Address::FACTORY_CONF => pattern & 0x31F,
                Address::CHOPCONF | Address::PWMCONF => pattern,
                Address::GSTAT => 0,
                Address::IFCNT => 1,
                _ if address.readable() => before,
                _ => 0,
            };
            assert_eq!(number(&mut wire, driver, address), after, "{address:?}");
            assert_eq!(number(&mut wire, driver, Address::IFCNT), 1, "{address:?}");
        }
    }
}

#[test]
fn after_power_up_registers_are_as_the_data_sheet_says() {
    let mut wire = wire();
    for (driver, pins) in [0, 1 << 3, 1 << 2, 3 << 2].into_iter().enumerate() {
        let mut number = |register| number(&mut wire, driver, register);
        assert_eq!(number(Address::GCONF), 0x101);
        assert_eq!(number(Address::GSTAT), 1);
        assert_eq!(number(Address::CHOPCONF), 0x1000_0053);
        assert_eq!(number(Address::PWMCONF), 0xC10D_0024);
        assert_eq!(number(Address::TSTEP), 0xF_FFFF);
        // Standing in StealthChop with the current of the run, as PDN_UART idles high.
        assert_eq!(number(Address::DRV_STATUS), 0xC01F_0000);
        assert_eq!(number(Address::IOIN), 0x2100_0040 | pins);
    }
    assert_eq!([0, 1, 2, 3].map(|driver| wire[driver].microsteps()), [8, 64, 32, 16]);
    assert!(!wire[0].setup().is_spread_cycle);
}

#[test]
fn a_datagram_is_refused_for_each_wrong_bit() {
    let write = WriteRequest::new(ADDRESSES[1], IHOLD_IRUN::default());
    let read = ReadRequest::new::<GCONF>(ADDRESSES[1]);
    for good in [write.bytes(), read.bytes()] {
        for bit in 0..8 * good.len() {
            let (mut wire, mut bad) = (wire(), good.to_vec());
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(wire.exchange(&bad), bad, "bit {bit} of {good:?}");
            assert_eq!([0, 1, 2, 3].map(|driver| get::<IFCNT>(&mut wire, driver).get()), [0; 4]);
        }
        for length in 0..good.len() {
            assert_eq!(wire().exchange(&good[..length]), good[..length]);
        }
    }
    // No sync, an address that no driver has, a write without data, a read with data.
    for body in [&[4, 0, 0][..], &[5, 4, 0], &[5, 0, 0x80], &[5, 0, 0, 1, 2, 3, 4]] {
        let sent = [body, &[tmc2209::crc(body)]].concat();
        assert_eq!(wire().exchange(&sent), sent);
    }
}

#[test]
fn writes_are_counted_to_255_and_on_from_0() {
    let mut wire = wire();
    for write in 1..=257_u32 {
        set(&mut wire, 2, PWMCONF::default());
        assert_eq!(u32::from(get::<IFCNT>(&mut wire, 2)), write % 256);
    }
    assert_eq!(get::<IFCNT>(&mut wire, 0).get(), 0, "that of another driver");
}

#[test]
fn current_and_microsteps_follow_their_registers() {
    let mut wire = wire();
    assert_eq!((wire[0].setup().run_ma, wire[0].setup().hold_ma), (1_768, 1_768));
    set(&mut wire, 0, IHOLD_IRUN::from(15 << 8 | 7));
    assert_eq!((wire[0].setup().run_ma, wire[0].setup().hold_ma), (884, 884), "PDN_UART idles high");
    set(&mut wire, 0, GCONF::from(1 << 6 | 1 << 7));
    assert_eq!((wire[0].setup().run_ma, wire[0].setup().hold_ma), (884, 442));
    assert_eq!(get::<DRV_STATUS>(&mut wire, 0).cs_actual(), 7);
    wire[0].set_load(FAST_STEPS_S, 0.0);
    assert_eq!(get::<DRV_STATUS>(&mut wire, 0).cs_actual(), 15);
    for resolution in 0..=8 {
        set(&mut wire, 0, CHOPCONF::from(resolution << 24 | 1 << 17 | 3));
        assert_eq!(wire[0].microsteps(), 256 >> resolution);
    }
    // The sensitive range: 0.18 V instead of 0.325 V.
    assert_eq!((wire[0].setup().run_ma, wire[0].setup().hold_ma), (490, 245));
}

#[test]
fn steps_are_counted_within_four_full_steps() {
    let mut wire = wire();
    let count = |wire: &mut Wire, driver| number(wire, driver, Address::MSCNT);
    wire[0].step(33);
    wire[3].step(-1);
    assert_eq!((count(&mut wire, 0), count(&mut wire, 3)), (32, 1_008), "8 and 16 microsteps");
    set(&mut wire, 0, GCONF::from(1 << 3));
    wire[0].step(2);
    assert_eq!(count(&mut wire, 0), 992, "with the direction inverted");
}

#[test]
fn speed_selects_the_chopper() {
    let mut wire = wire();
    wire[0].set_load(FAST_STEPS_S, 0.0);
    assert_eq!(get::<TSTEP>(&mut wire, 0).get(), FAST_TSTEP);
    wire[0].set_load(-FAST_STEPS_S / 2.0, 0.0);
    assert_eq!(get::<TSTEP>(&mut wire, 0).get(), 187, "backward");
    for (threshold, is_spread_cycle) in [(0, false), (187, false), (188, true)] {
        set(&mut wire, 0, TPWMTHRS::from(threshold));
        turn(&mut wire, 0, -FAST_STEPS_S / 2.0, 0.0);
        assert_eq!(wire[0].setup().is_spread_cycle, is_spread_cycle, "{threshold}");
        assert_eq!(get::<DRV_STATUS>(&mut wire, 0).stealth(), !is_spread_cycle);
        assert_eq!(get::<SG_RESULT>(&mut wire, 0).get() == 0, is_spread_cycle);
    }
    wire[0].set_load(0.0, 0.0);
    assert!(!wire[0].setup().is_spread_cycle);
    set(&mut wire, 0, GCONF::from(1 << 2));
    assert!(wire[0].setup().is_spread_cycle);
    assert!(get::<DRV_STATUS>(&mut wire, 0).stst());
}

#[test]
fn load_lowers_the_reading_on_a_line() {
    let off_line = || {
        let mut wire = wire();
        let off = |percent: i32| {
            turn(&mut wire, 1, FAST_STEPS_S, f64::from(percent) / 100.0);
            let reading = i32::from(get::<SG_RESULT>(&mut wire, 1).get());
            assert_eq!(reading % 2, 0);
            (reading - 4 * (100 - percent)).abs()
        };
        (0..=100).map(off).collect::<Vec<_>>()
    };
    assert!(off_line().into_iter().all(|off| off <= 11), "{:?}", off_line());
    assert!(off_line().into_iter().filter(|off| *off > 4).count() > 20, "noise");
    assert_eq!(off_line(), off_line());
}

#[test]
fn diag_tells_of_a_stall_where_it_may() {
    let mut wire = wire();
    let stalls = |wire: &mut Wire, speed_steps_s, load| {
        turn(wire, 0, speed_steps_s, load);
        assert_eq!(get::<IOIN>(wire, 0).diag(), wire[0].diag());
        wire[0].diag()
    };
    assert!(!stalls(&mut wire, FAST_STEPS_S, 1.0), "not set up");
    set(&mut wire, 0, TCOOLTHRS::from(FAST_TSTEP));
    set(&mut wire, 0, SGTHRS::from(50));
    assert!(stalls(&mut wire, FAST_STEPS_S, 1.0));
    assert!(stalls(&mut wire, FAST_STEPS_S, 0.8));
    assert!(!stalls(&mut wire, FAST_STEPS_S, 0.7));
    assert!(!stalls(&mut wire, FAST_STEPS_S * 0.98, 1.0), "slower than TCOOLTHRS");
    assert!(!wire[1].diag(), "that of another driver");
    set(&mut wire, 0, TCOOLTHRS::from(0xF_FFFF));
    assert!(stalls(&mut wire, 300.0, 0.0), "too slow to be measured");
    assert!(!stalls(&mut wire, 400.0, 0.0));
    set(&mut wire, 0, GCONF::from(1 << 2));
    assert!(!stalls(&mut wire, FAST_STEPS_S, 1.0), "in SpreadCycle");
}

#[test]
fn a_driver_that_was_off_has_forgotten_all() {
    let mut wire = wire();
    set(&mut wire, 0, GSTAT::from(0b110));
    assert!(get::<GSTAT>(&mut wire, 0).reset(), "cleared by ones");
    set(&mut wire, 0, GSTAT::from(0b001));
    assert!(!get::<GSTAT>(&mut wire, 0).reset());
    assert!(get::<GSTAT>(&mut wire, 1).reset(), "that of another driver");
    set(&mut wire, 0, IHOLD_IRUN::from(0));
    wire[0].step(1);
    wire[0].set_fault(Some(DriverFault::Off));
    assert!(ask::<GCONF>(&mut wire, 0).is_none());
    assert!(ask::<GCONF>(&mut wire, 1).is_some(), "others are on");
    set(&mut wire, 0, IHOLD_IRUN::from(0));
    wire[0].set_fault(None);
    assert!(get::<GSTAT>(&mut wire, 0).reset());
    assert_eq!((get::<IFCNT>(&mut wire, 0).get(), get::<MSCNT>(&mut wire, 0).get()), (0, 0));
    assert_eq!(wire[0].setup().run_ma, 1_768);
}

#[test]
fn a_late_reply_comes_before_the_next_echo() {
    let mut wire = wire();
    wire[0].set_fault(Some(DriverFault::Late));
    assert!(ask::<GCONF>(&mut wire, 0).is_none());
    let other = ReadRequest::new::<IOIN>(ADDRESSES[1]);
    let heard = wire.exchange(other.bytes());
    let (late, rest) = heard.split_at(8);
    assert_eq!(response(late).unwrap().data_u32(), 0x101);
    assert_eq!(response(&rest[4..]).unwrap().register::<IOIN>().unwrap().version(), 0x21);
    assert_eq!(&rest[..4], other.bytes());
}

#[test]
fn every_second_reply_is_garbled() {
    let mut wire = wire();
    get::<GCONF>(&mut wire, 3);
    wire[3].set_fault(Some(DriverFault::Garbled));
    for _ in 0..50 {
        assert!(ask::<GCONF>(&mut wire, 3).is_some());
        assert!(ask::<GCONF>(&mut wire, 3).is_none());
    }
}

#[test]
fn each_fault_has_its_flags() {
    for (fault, flags, stops) in [
        (DriverFault::Hot, 0b0001_0000_0001, false),
        (DriverFault::Overheated, 0b0011_0000_0011, true),
        (DriverFault::Shorted, 0b0000_0000_0100, true),
        (DriverFault::OpenCoil, 0b0000_0100_0000, false),
    ] {
        let mut wire = wire();
        wire[2].set_fault(Some(fault));
        for clear in [1, 7] {
            assert_eq!(u32::from(get::<DRV_STATUS>(&mut wire, 2)) & 0xFFFF, flags, "{fault:?}");
            assert_eq!((get::<GSTAT>(&mut wire, 2).drv_err(), wire[2].diag()), (stops, stops), "{fault:?}");
            set(&mut wire, 2, GSTAT::from(clear));
        }
        wire[2].set_fault(None);
        switch_off_and_on(&mut wire, 2);
        assert_eq!(u32::from(get::<DRV_STATUS>(&mut wire, 2)) & 0xFFFF, 0, "{fault:?}");
        assert_eq!(
            (get::<GSTAT>(&mut wire, 2).drv_err(), wire[2].diag()),
            (stops, false),
            "{fault:?}: until it is cleared"
        );
        set(&mut wire, 2, GSTAT::from(2));
        assert_eq!(u32::from(get::<GSTAT>(&mut wire, 2)), 0, "{fault:?}");
    }
}

fn switch_off_and_on(wire: &mut Wire, driver: usize) {
    const SWITCHED_ON: u32 = 0x1000_0053;
    for chopconf in [SWITCHED_ON & !0xF, SWITCHED_ON] {
        set(wire, driver, CHOPCONF::from(chopconf));
    }
}

/// As the data sheet has it (6.3): the driver stays off until it is switched off, and finds a short that is still there anew.
#[test]
fn a_short_that_was_found_keeps_the_motor_off_until_toff_has_been_0() {
    let mut wire = wire();
    let is_reported = |wire: &mut Wire| {
        let reported = [get::<DRV_STATUS>(wire, 1).s2ga(), get::<GSTAT>(wire, 1).drv_err(), wire[1].diag()];
        set(wire, 1, GSTAT::from(7));
        reported
    };
    wire[1].set_fault(Some(DriverFault::Shorted));
    assert_eq!(is_reported(&mut wire), [true; 3]);
    switch_off_and_on(&mut wire, 1);
    assert_eq!(is_reported(&mut wire), [true; 3], "it is still there");
    wire[1].set_fault(None);
    assert_eq!(is_reported(&mut wire), [true; 3], "nobody has switched the driver off");
    set(&mut wire, 1, CHOPCONF::from(0x1000_0055));
    assert_eq!(is_reported(&mut wire), [true; 3], "another TOFF is not off");
    switch_off_and_on(&mut wire, 1);
    assert_eq!(is_reported(&mut wire), [false, true, false], "the flag of the error, until it is cleared");
    assert_eq!(is_reported(&mut wire), [false; 3]);
}

#[test]
fn two_drivers_of_one_address_are_heard_as_noise() {
    let mut wire = Wire::new([0, 2, 2, 3]);
    for &register in Address::ALL {
        let heard = after_echo(&mut wire, ReadRequest::from_addr(2, register).bytes());
        assert_eq!(heard.len(), 8);
        assert!(response(&heard).is_none(), "{register:?}");
    }
    // Both hear what is written.
    set(&mut wire, 1, IHOLD_IRUN::from(0));
    assert_eq!((wire[1].setup().run_ma, wire[2].setup().run_ma), (55, 55));
    wire[1].set_fault(Some(DriverFault::Off));
    assert!(ask::<GCONF>(&mut wire, 1).is_some(), "the other alone");
}
