//! The task that sets the drivers and watches them.

use core::convert::Infallible;

use embassy_futures::select::select;
use embassy_time::Timer;
use embedded_storage_async::nor_flash::NorFlash;
use isostep_motion::{Alarm, Motor, State};
use tmc2209::reg::{CHOPCONF, DRV_STATUS, GCONF, GSTAT, IHOLD_IRUN, SG_RESULT, SGTHRS, SLAVECONF, TCOOLTHRS, TPWMTHRS};

use super::exchange::{DriverOnWire, Failure, SEND_DELAY};
use super::health::{Health, is_off, is_shorted};
use super::registers::Registers;
use super::{DRIVERS, DriverNews, Drivers, Known, Wire, is_watched, motor};
use crate::controller::Controller;
use crate::news::News;

/// The time between two rounds.
const ROUND_MS: u64 = 100;
/// Its settings are read back in one round of so many. What makes a driver forget them is reported in every round.
const CHECK_ROUNDS: u8 = 8;
/// A coil that seems open so often in a row is: a motor that turns fast makes one seem so now and then.
const OPEN_ROUNDS: u8 = 5;

impl<F: NorFlash> Controller<'_, F> {
    /// Sets the drivers as the settings say. Call it on a controller that was made [`with_drivers`](Controller::with_drivers),
    /// after [`load`](Controller::load) and before anything moves. A driver that does not answer locks the machine.
    ///
    /// # Cancellation
    /// Some of the drivers are set, and nothing has moved.
    pub async fn set_drivers<W: Wire>(&self, wire: &mut W) {
        if let Some(drivers) = &self.drivers {
            self.round(drivers, wire).await;
        }
    }

    /// From then on asks the drivers ten times a second how they are, and sets them anew when settings have changed. One that
    /// fails stops the machine; what else it reports is reported to the consoles. Without it a changed setting is never
    /// answered. Without drivers it only waits.
    ///
    /// # Cancellation
    /// The drivers keep what they are set to, and nobody watches them any more. An axis that moves goes on.
    pub async fn watch_drivers<W: Wire>(&self, mut wire: W) -> Infallible {
        let Some(drivers) = &self.drivers else { core::future::pending().await };
        loop {
            let pause_ms = if drivers.measured.get().is_some() { 0 } else { ROUND_MS };
            select(drivers.asked.wait(), Timer::after_millis(pause_ms)).await;
            self.measure(drivers, &mut wire).await;
            self.round(drivers, &mut wire).await;
        }
    }

    /// True if the drivers are being set to settings that have changed.
    pub fn sets_drivers(&self) -> bool {
        self.drivers.as_ref().is_some_and(|drivers| drivers.pending.get())
    }

    /// Waits until the drivers are set to the settings, as far as they answer. The caller has the turn.
    ///
    /// # Cancellation
    /// Safe: it only waits.
    pub(crate) async fn drivers_set(&self) {
        let Some(drivers) = &self.drivers else { return };
        while drivers.pending.get() {
            drivers.done.wait().await;
        }
    }

    async fn round<W: Wire>(&self, drivers: &Drivers, wire: &mut W) {
        drivers.asked.reset();
        for driver in 0..DRIVERS {
            self.attend(drivers, driver, wire).await;
        }
        // Other settings may have come meanwhile.
        if !drivers.asked.signaled() {
            drivers.pending.set(false);
            drivers.done.signal(());
        }
    }

    /// Sets a driver if it has to be, asks it how it is, and tells what has changed.
    async fn attend<W: Wire>(&self, drivers: &Drivers, driver: usize, wire: &mut W) {
        let Some((motor, wanted)) = self.wanted(drivers, driver) else {
            return drivers.note(driver, |known| *known = Known::UNKNOWN);
        };
        let mut line = DriverOnWire { wire, address: drivers.hardware.addresses[driver] };
        let mut known = drivers.known.borrow()[driver];
        let before = known.health;
        let is_locked = || matches!(self.machine.state(), State::Alarm(_));
        // Somebody has unlocked the machine: then it is tried again. If that is done from here on, the next round tries it.
        let was_locked = is_locked();
        if before.stops() && !was_locked {
            known.set = None;
        }
        known.health = line.ask(&mut known, wanted, is_locked).await.unwrap_or_else(|failure| {
            known.set = None;
            failure.into()
        });
        let has_locked =
            matches!(self.machine.state(), State::Alarm(Alarm::DriverFailed { motor: whose }) if whose == motor);
        known.with_stall(before, has_locked);
        drivers.note(driver, |noted| *noted = known);
        let was_unlocked = was_locked && !is_locked();
        if known.health.stops() && !was_unlocked {
            self.machine.driver_failed(motor);
        }
        self.tell_health(motor, before, known.health);
    }

    /// Tells the consoles what has changed.
    fn tell_health(&self, motor: Motor, before: Health, health: Health) {
        let is_news = health != before && (before != Health::Unknown || health != Health::Well);
        if is_news {
            self.publish(News::Driver(DriverNews { motor, health }));
        }
    }

    /// The motor of a driver that is watched, and what the driver is to be set to.
    fn wanted(&self, drivers: &Drivers, driver: usize) -> Option<(Motor, Registers)> {
        self.with(|program| {
            let settings = &program.settings;
            let motor = motor(driver, settings).filter(|&motor| is_watched(motor, settings))?;
            let looks = (drivers.looks_mask.get() | settings.stall_alarm_mask & settings.stall_homing_mask)
                & (1 << motor.axis as u16)
                != 0;
            Some((motor, Registers::new(settings, motor.axis as usize, drivers.hardware.sense_milliohms, looks)))
        })
    }
}

impl Drivers {
    fn note(&self, driver: usize, change: impl FnOnce(&mut Known)) {
        change(&mut self.known.borrow_mut()[driver]);
    }
}

impl<W: Wire> DriverOnWire<'_, W> {
    /// Reads what the driver reports, and sets it if it is not set to `wanted`.
    async fn ask(
        &mut self,
        known: &mut Known,
        wanted: Registers,
        is_locked: impl Fn() -> bool,
    ) -> Result<Health, Failure> {
        let (is_unset, before) = (known.set.is_none(), DRV_STATUS(known.status));
        let mut is_kept = false;
        if is_unset {
            // Its motor is off for a moment, which clears a short that the driver has kept until now.
            is_kept = is_shorted(&before) && is_shorted(&self.read().await?);
            self.write(&[self.request(CHOPCONF(wanted.off()))]).await?;
        }
        let global: GSTAT = self.read().await?;
        // What a driver that is not set has kept was before the machine was switched on, or has locked it.
        let is_locked = is_locked();
        let is_old = is_unset && (known.health == Health::Unknown || is_locked);
        // What was read and nothing else is cleared, so whatever happens from now on is for the next round.
        if global.reset() || global.drv_err() {
            self.write(&[self.request(global)]).await?;
        }
        let restarted = global.reset() && !is_old;
        if known.set != Some(wanted) || restarted {
            self.set(wanted).await?;
            known.set = Some(wanted);
        } else if known.is_due()
            && (self.read::<CHOPCONF>().await?.0 != wanted.chopconf || self.read::<GCONF>().await?.0 != wanted.gconf)
        {
            return Err(Failure::NotTaken);
        }
        let status: DRV_STATUS = self.read().await?;
        (known.status, known.sg_result) = (status.0, self.read::<SG_RESULT>().await?.0 as u16);
        // While an error lasts its flag cannot be cleared. If it ended after the machine was unlocked, the motor was off again.
        let is_reported = is_old || is_kept || is_locked && is_off(&before);
        let has_failed = global.drv_err() && !is_reported;
        // A driver that has cooled has no other trace of it, and a short stays until the driver is switched off.
        let failed = has_failed.then_some(if is_shorted(&before) { Health::Shorted } else { Health::Overheated });
        let health = if restarted { Health::Restarted } else { Health::judge(failed, global.uv_cp(), &status) };
        Ok(known.with_coils(health, &status))
    }

    async fn set(&mut self, wanted: Registers) -> Result<(), Failure> {
        let mut patient = SLAVECONF(0);
        patient.set_send_delay(SEND_DELAY);
        self.write(&[
            self.request(patient),
            self.request(GCONF(wanted.gconf)),
            self.request(IHOLD_IRUN(wanted.ihold_irun)),
            self.request(CHOPCONF(wanted.chopconf)),
        ])
        .await?;
        // In two parts, which need room one after the other.
        self.write(&[
            self.request(TPWMTHRS(wanted.tpwmthrs)),
            self.request(TCOOLTHRS(wanted.tcoolthrs)),
            self.request(SGTHRS(wanted.sgthrs)),
        ])
        .await
    }
}

impl Known {
    /// True if its settings are to be read back in this round.
    fn is_due(&mut self) -> bool {
        self.rounds = (self.rounds + 1) % CHECK_ROUNDS;
        self.rounds == 0
    }

    /// A driver that is well, and was, and has locked the machine nevertheless, has done so by its output.
    fn with_stall(&mut self, before: Health, has_locked: bool) {
        let had_locked = core::mem::replace(&mut self.has_locked, has_locked);
        let was_well = matches!(before, Health::Well | Health::Hot) && !had_locked;
        if has_locked && self.health == Health::Well && (was_well || before == Health::Stalled) {
            self.health = Health::Stalled;
        }
    }

    /// `health`, unless nothing worse is found than coils that have seemed open for some time while the motor turned.
    fn with_coils(&mut self, health: Health, status: &DRV_STATUS) -> Health {
        if !status.stst() {
            let is_open = (status.ola() || status.olb()) && !status.stealth();
            self.open = if is_open { self.open.saturating_add(1) } else { 0 };
        }
        if health == Health::Well && self.open >= OPEN_ROUNDS { Health::OpenCoil } else { health }
    }
}
