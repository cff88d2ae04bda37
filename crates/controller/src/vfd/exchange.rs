//! Requests, and the replies that they want.

use embassy_time::{Duration, Instant, Timer};
use modbus_core::rtu::{self, Header, RequestAdu, client};
use modbus_core::{FunctionCode, RequestPdu};

use super::report::VfdHealth;
use super::types::{Read, Write};
use super::{LineFormat, VFD_HEARD_BYTES_MAX, VFD_SENT_BYTES_MAX, VfdWire};

/// The bit of a function by which a VFD refuses it.
const REFUSED: u8 = 0x80;
/// A reply without data: address, function, and a checksum.
const FRAME_BYTES: usize = 4;
/// The most words of a reply.
pub const WORDS_MAX: usize = 5;

/// The silence before a frame: 3.5 characters at 9,600 baud are 4 ms, and a Huanyang wants 6.
const GAP: Duration = Duration::from_millis(6);
/// A spindle is known for so long to turn as a reply says, counted from its request. If another try would end later, the VFD has
/// failed. Thread mode may be away for a while then: after 300 ms the spindle is being stopped.
const KNOWN_FOR: Duration = Duration::from_millis(280);

/// A request, and what its reply is to be.
#[derive(Clone, Copy)]
pub struct VfdRequest {
    pub register: u16,
    function: u8,
    data: [u8; 7],
    data_bytes: u8,
    /// What follows the function in a reply first, so that no other reply is taken for it.
    begin: [u8; 4],
    begin_bytes: u8,
    /// VfdWords that follow then.
    words: u8,
    /// A byte follows that says nothing here.
    has_status: bool,
}

impl VfdRequest {
    const NOTHING: Self = Self {
        register: 0,
        function: 0,
        data: [0; 7],
        data_bytes: 0,
        begin: [0; 4],
        begin_bytes: 0,
        words: 0,
        has_status: false,
    };

    fn new(function: u8, register: u16, data: &[u8], begin: &[u8]) -> Self {
        let mut request =
            Self { function, register, data_bytes: data.len() as u8, begin_bytes: begin.len() as u8, ..Self::NOTHING };
        request.data[..data.len()].copy_from_slice(data);
        request.begin[..begin.len()].copy_from_slice(begin);
        request
    }

    pub fn write(how: Write, register: u16, word: u16) -> Self {
        let ([high, low], [first, second]) = (register.to_be_bytes(), word.to_be_bytes());
        let same = |function, data: &[u8]| Self::new(function, register, data, data);
        match how {
            Write::Register => same(6, &[high, low, first, second]),
            Write::Coil => Self { register: word, ..same(5, &[first, second, 0xFF, 0]) },
            Write::Registers => {
                let data = [high, low, 0, 1, 2, first, second];
                Self::new(16, register, &data, &data[..4])
            }
            Write::HuanyangRun => Self { has_status: true, ..Self::new(3, register, &[1, second], &[1]) },
            Write::HuanyangSpeed => same(5, &[2, first, second]),
        }
    }

    pub fn read(how: Read, register: u16, words: u8) -> Self {
        let [high, low] = register.to_be_bytes();
        let of = |function| Self::new(function, register, &[high, low, 0, words], &[2 * words]);
        let request = match how {
            Read::Holding => of(3),
            Read::Input => of(4),
            Read::Huanyang => Self::new(4, register, &[3, low, 0, 0], &[3, low]),
        };
        Self { words, ..request }
    }

    fn frame<'b>(&self, address: u8, bytes: &'b mut [u8; VFD_SENT_BYTES_MAX]) -> &'b [u8] {
        let data = &self.data[..self.data_bytes.into()];
        let pdu = RequestPdu(modbus_core::Request::Custom(FunctionCode::new(self.function), data));
        let count = client::encode_request(RequestAdu { hdr: Header { slave: address }, pdu }, bytes);
        &bytes[..count.unwrap_or_default()]
    }

    fn reply_bytes(&self) -> usize {
        FRAME_BYTES + usize::from(self.begin_bytes) + 2 * usize::from(self.words) + usize::from(self.has_status)
    }

    /// The words of a reply.
    fn words_of(&self, address: u8, heard: &[u8]) -> Result<[u16; WORDS_MAX], VfdHealth> {
        let refusal = heard.get(1).filter(|&&function| function == self.function | REFUSED);
        let data_bytes = if refusal.is_some() { 1 } else { self.reply_bytes() - FRAME_BYTES };
        let frame = rtu::extract_frame(heard, 1 + data_bytes).ok().flatten();
        let Some(frame) = frame else { return Err(self.why_not(heard)) };
        let (begin, data) = (&self.begin[..self.begin_bytes.into()], &frame.pdu[1..]);
        match data.strip_prefix(begin) {
            _ if frame.slave != address => Err(VfdHealth::Other),
            _ if refusal.is_some() => Err(VfdHealth::Refused(data[0])),
            Some(left) if frame.pdu[0] == self.function => {
                let mut words = [0; WORDS_MAX];
                for (word, bytes) in words.iter_mut().zip(left.as_chunks().0) {
                    *word = u16::from_be_bytes(*bytes);
                }
                Ok(words)
            }
            _ => Err(self.why_not(heard)),
        }
    }

    fn why_not(&self, heard: &[u8]) -> VfdHealth {
        match heard.len() {
            0 => VfdHealth::Silent,
            count if count < self.reply_bytes() => VfdHealth::Garbled,
            _ if rtu::extract_frame(heard, self.reply_bytes() - 3).is_ok_and(|frame| frame.is_some()) => {
                VfdHealth::Other
            }
            _ => VfdHealth::Garbled,
        }
    }
}

/// A VFD on its wire.
pub struct VfdOnWire<'a, W> {
    pub wire: &'a mut W,
    pub line: LineFormat,
    pub address: u8,
    pub timeout: Duration,
    /// When it was asked last what it answered then: how the spindle turns.
    pub known_at: &'a mut Instant,
    /// Exchanges that had to be repeated.
    pub repeats: u32,
}

impl<W: VfdWire> VfdOnWire<'_, W> {
    /// Asks until it is answered, or until too long is nothing known of the VFD.
    pub async fn exchange(&mut self, request: &VfdRequest) -> Result<[u16; WORDS_MAX], VfdHealth> {
        let mut bytes = [0; VFD_SENT_BYTES_MAX];
        let sent = request.frame(self.address, &mut bytes);
        let lasts = GAP + self.line.time(sent.len()) + self.timeout;
        let asked_at = Instant::now();
        loop {
            Timer::after(GAP).await;
            let mut heard = [0; VFD_HEARD_BYTES_MAX];
            let heard = &mut heard[..request.reply_bytes()];
            let count = self.wire.exchange(self.line, sent, heard, self.timeout).await;
            match request.words_of(self.address, &heard[..count]) {
                Ok(words) => {
                    // Of several tries it may be the first that is answered.
                    if request.words > 0 {
                        *self.known_at = asked_at;
                    }
                    return Ok(words);
                }
                Err(why) if Instant::now() + lasts > *self.known_at + KNOWN_FOR => return Err(why),
                Err(_) => self.repeats += 1,
            }
        }
    }
}
