//! The board's end of the wire to a VFD.

use embassy_time::{Duration, Instant, Timer};
use isostep_controller::{LineFormat, Parity, VfdWire};

use crate::record::VfdFrame;
use crate::time::Clock;
use crate::world::Shared;

/// That of the VFD: another board's characters are none.
const VFD_LINE: LineFormat = LineFormat { baud: 9_600, parity: Parity::None };

/// The wire, with the times of characters.
pub(crate) struct VfdLine {
    world: Shared,
    clock: Clock,
    /// The reply that has not come yet, and when all of it will have come.
    coming: Option<(Instant, Vec<u8>)>,
}

impl VfdLine {
    pub(crate) fn new(world: &Shared, clock: &Clock) -> Self {
        Self { world: world.clone(), clock: clock.clone(), coming: None }
    }

    pub(crate) fn clock(&self) -> &Clock {
        &self.clock
    }

    fn note(&self, is_reply: bool, bytes: &[u8]) {
        let frame = VfdFrame { t_ns: self.clock.now_ns(), is_reply, bytes: bytes.to_vec() };
        self.world.borrow_mut().note_vfd_frame(frame);
    }
}

impl VfdWire for VfdLine {
    async fn exchange(&mut self, line: LineFormat, sent: &[u8], heard: &mut [u8], limit: Duration) -> usize {
        self.coming.take_if(|(at, _)| *at <= Instant::now());
        Timer::after(line.time(sent.len())).await;
        self.note(false, sent);
        let sent_at = Instant::now();
        let reply = (line == VFD_LINE).then(|| self.world.borrow_mut().exchange_with_vfd(sent)).flatten();
        let reply = reply.map(|(bytes, after_ns)| {
            (sent_at + Duration::from_micros(after_ns / 1_000) + line.time(bytes.len()), bytes)
        });
        // One that was late comes before, and collides with another that comes at the same time.
        let ends = sent_at + limit;
        let (first, second) = match self.coming.take() {
            Some(late) => (Some(late), reply),
            None => (reply, None),
        };
        self.coming = second;
        match first {
            Some((at, bytes)) if at <= ends => {
                // Of fewer bytes nobody knows that they are all.
                Timer::at(if bytes.len() < heard.len() { ends } else { at }).await;
                self.note(true, &bytes);
                heard.iter_mut().zip(bytes).map(|(heard, byte)| *heard = byte).count()
            }
            late => {
                self.coming = late.or(self.coming.take());
                Timer::at(ends).await;
                0
            }
        }
    }
}
