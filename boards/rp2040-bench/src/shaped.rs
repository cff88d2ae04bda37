//! The axes of shaped moves in the benchmark: what each makes of the chunks of a chain.

use isostep_profile::CountedPhase;
use isostep_profile::chain::Chunk;
use isostep_profile::shaper::{Combination, Impulses, Shaped, Shaper, ShaperInput};

use crate::AXES;

/// The number of phases that are kept of each axis, as in the firmware.
const PHASES: usize = 64;

/// Three axes with the same shaper.
pub struct ShapedAxes {
    axes: [Shaped<PHASES>; AXES],
    inputs: [ShaperInput; AXES],
    impulses: Impulses,
    top_steps_s: f64,
    /// The chunk that was read last.
    last: Option<Chunk<AXES>>,
}

impl ShapedAxes {
    /// Axes with this shaper and this top speed.
    pub fn new(shaper: &Shaper, top_steps_s: f64) -> Self {
        let (axes, inputs) = ([const { Shaped::empty() }; AXES], [ShaperInput::empty(); AXES]);
        Self { axes, inputs, impulses: shaper.impulses(), top_steps_s, last: None }
    }

    /// Lets an axis read the next chunk.
    pub fn read(&mut self, axis: usize, chunk: &Chunk<AXES>) {
        let (shaped, input) = (&mut self.axes[axis], &mut self.inputs[axis]);
        match &self.last {
            None => {
                *input = ShaperInput::begin(Combination::Axis(axis), chunk, shaped, self.impulses, self.top_steps_s)
            }
            Some(last) => input.go_on(last, chunk),
        }
        while input.read(chunk, shaped) {}
    }

    /// The next shaped phase of an axis; `None` if no more is known.
    pub fn next_phase(&mut self, axis: usize) -> Option<CountedPhase> {
        self.axes[axis].next_phase()
    }

    /// Notes that all axes have read this chunk.
    pub fn have_read(&mut self, chunk: Chunk<AXES>) {
        self.last = Some(chunk);
    }
}
