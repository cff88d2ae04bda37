//! The extent of a proof: which measurements, how much of each, and by which wires.

/// An input that a wire connects with GP28.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Jumper {
    /// X's limit switch, GP9
    Limit,
    /// the emergency stop, GP12
    Estop,
}

impl Jumper {
    /// Every input that a wire may go to.
    pub const ALL: [Self; 2] = [Self::Limit, Self::Estop];

    /// Its pad.
    pub fn pad(self) -> u8 {
        match self {
            Self::Limit => 9,
            Self::Estop => 12,
        }
    }
}

/// The extent of the measurements.
#[derive(Clone, Debug)]
pub struct Effort {
    /// The rates at which edges are compared, steps/s.
    pub rates: Vec<u32>,
    /// Windows of a move, at most; those of a whole move if it has fewer.
    pub windows: usize,
    /// The same for the finer stamps by two stampers.
    pub pair_windows: usize,
    /// The step of the search for the highest rate, steps/s.
    pub rate_step: u32,
    /// Stops of each kind.
    pub stops: u32,
    /// Starts of each kind.
    pub starts: u32,
    /// Short moves.
    pub moves: u32,
    /// Time for which the crystal is compared, s.
    pub crystal_s: f64,
}

impl Effort {
    /// Everything.
    pub fn full() -> Self {
        Self {
            rates: vec![100_000, 1_000_000, 2_000_000],
            windows: usize::MAX,
            // Three pairs for each window: all would take most of the time.
            pair_windows: 24,
            rate_step: 50_000,
            stops: 24,
            starts: 12,
            moves: 4_000,
            crystal_s: 30.0,
        }
    }

    /// A look: a minute.
    pub fn quick() -> Self {
        Self { windows: 6, pair_windows: 4, stops: 6, starts: 4, moves: 800, crystal_s: 3.0, ..Self::full() }
    }
}

/// The measurements that are made.
#[derive(Clone, Debug)]
pub struct How {
    /// The wires that are there.
    pub jumpers: Vec<Jumper>,
    /// Their extent.
    pub effort: Effort,
    /// The laser's pin may be switched on.
    pub laser: bool,
    /// The measurements to make; all if none is named.
    pub only: Vec<Part>,
}

/// A measurement that can be made alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
#[expect(missing_docs, reason = "each has the words of its measurement")]
pub enum Part {
    Ready,
    Edges,
    Intervals,
    Rates,
    Stops,
    Moves,
    Load,
    Cache,
    Starts,
    Crystal,
    Laser,
}
