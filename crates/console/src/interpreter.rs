//! Lines to commands: the modal state and where the program believes the machine to be.

use crate::{
    AXES, Block, Command, Error, Modal, Motion, MotionMode, Rate, Settings, State,
    block::{NonModal, Words},
    command::gcode_allowed,
    system,
};

/// No target may lie farther from zero on any axis: an `f32` still tells 0.001 mm apart there.
pub const MAX_COORDINATE_MM: f32 = 10_000.0;
/// The slowest feed.
pub const MIN_FEED_MM_MIN: f32 = 1.0;

const INCH_MM: f32 = 25.4;

/// Understands one line at a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Interpreter {
    modal: Modal,
    position_mm: [f32; AXES],
}

impl Interpreter {
    /// The modal state of power-up, at machine position zero.
    pub fn new() -> Self {
        Self::default()
    }

    /// The modal state in force after the last line accepted.
    pub fn modal(&self) -> &Modal {
        &self.modal
    }

    /// Where the last move accepted ends, in machine coordinates.
    pub fn position_mm(&self) -> [f32; AXES] {
        self.position_mm
    }

    /// Says where the machine is: after homing, a reset, or a move refused or cut short.
    pub fn set_position_mm(&mut self, position_mm: [f32; AXES]) {
        self.position_mm = position_mm;
    }

    /// Puts the modal state back to that of power-up; the position stays.
    pub fn reset(&mut self) {
        self.modal = Modal::default();
    }

    /// Understands a line of [`LineAssembler`](crate::LineAssembler), if the machine may be asked in `state`.
    /// On success, takes over its modal state and the position it ends at.
    ///
    /// # Errors
    /// Grbl's reason; then nothing has changed.
    pub fn interpret(&mut self, line: &str, state: State, settings: &Settings) -> Result<Command, Error> {
        if line.is_empty() {
            return Ok(Command::Block(Block::default()));
        }
        if line.starts_with('$') {
            let command = system::parse(line)?;
            return command.allowed(state, settings).map(|()| command);
        }
        gcode_allowed(state)?;
        let mut next = *self;
        let block = next.block(Words::read(line)?)?;
        *self = next;
        Ok(Command::Block(block))
    }

    /// Applies a block to this state, in RS274's order; the caller drops the state if that fails.
    fn block(&mut self, mut words: Words) -> Result<Block, Error> {
        self.modes(&mut words)?;
        let dwell_s = match words.non_modal {
            Some(NonModal::Dwell) => Some(words.take(b'P').ok_or(Error::ValueMissing)?),
            _ => None,
        };
        let motion = self.motion(&mut words)?;
        words.check_all_used()?;
        if words.ends_program {
            self.modal.end_program();
        }
        Ok(Block { dwell_s, motion, ends_program: words.ends_program })
    }

    fn modes(&mut self, words: &mut Words) -> Result<(), Error> {
        let modal = &mut self.modal;
        modal.inches = words.inches.unwrap_or(modal.inches);
        modal.incremental = words.incremental.unwrap_or(modal.incremental);
        modal.motion = words.motion.unwrap_or(modal.motion);
        modal.spindle = words.spindle.unwrap_or(modal.spindle);
        modal.coolant = words.coolant.map_or(modal.coolant, |coolant| modal.coolant.then(coolant));
        modal.speed_rpm = words.take(b'S').unwrap_or(modal.speed_rpm);
        modal.tool = words.take(b'T').map_or(modal.tool, |tool| tool as u8);
        if let Some(feed) = words.take(b'F') {
            self.modal.feed_mm_min = feed * self.unit_mm();
        }
        Ok(())
    }

    fn motion(&mut self, words: &mut Words) -> Result<Option<Motion>, Error> {
        let axes = words.take_axes();
        let moves = axes.iter().any(Option::is_some);
        if moves && self.modal.motion == MotionMode::Cancelled {
            return Err(Error::UnusedAxisWords);
        }
        let target_mm = self.target_mm(axes)?;
        let motion = if words.non_modal == Some(NonModal::GoHome) {
            Some(self.go_home(axes, moves.then_some(target_mm)))
        } else if moves || words.motion.is_some() {
            let rate = self.rate()?;
            moves.then_some(Motion::Move { target_mm, rate })
        } else {
            None
        };
        if let Some(Motion::Move { target_mm, .. } | Motion::GoHome { target_mm, .. }) = motion {
            self.position_mm = target_mm;
        }
        Ok(motion)
    }

    /// With axis words, only the axes named go home.
    fn go_home(&self, axes: [Option<f32>; AXES], via_mm: Option<[f32; AXES]>) -> Motion {
        let mut target_mm = [0.0; AXES];
        if via_mm.is_some() {
            for axis in (0..AXES).filter(|&axis| axes[axis].is_none()) {
                target_mm[axis] = self.position_mm[axis];
            }
        }
        Motion::GoHome { via_mm, target_mm }
    }

    fn target_mm(&self, axes: [Option<f32>; AXES]) -> Result<[f32; AXES], Error> {
        let mut target_mm = self.position_mm;
        for (target, value) in target_mm.iter_mut().zip(axes) {
            let Some(value) = value else { continue };
            let from = if self.modal.incremental { *target } else { 0.0 };
            *target = from + value * self.unit_mm();
            if target.abs() > MAX_COORDINATE_MM {
                return Err(Error::InvalidTarget);
            }
        }
        Ok(target_mm)
    }

    fn rate(&self) -> Result<Rate, Error> {
        let mm_min = self.modal.feed_mm_min;
        match self.modal.motion {
            MotionMode::Linear if mm_min < MIN_FEED_MM_MIN => Err(Error::NoFeed),
            MotionMode::Linear => Ok(Rate::Feed { mm_min }),
            MotionMode::Rapid | MotionMode::Cancelled => Ok(Rate::Rapid),
        }
    }

    fn unit_mm(&self) -> f32 {
        if self.modal.inches { INCH_MM } else { 1.0 }
    }
}
