//! Numbers that senders know, each with words of ours.

/// An enum of such numbers: `Name = number, "words";`.
macro_rules! codes {
    ($(#[$doc:meta])* $codes:ident { $($name:ident = $code:literal, $words:literal;)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        // A whole word: what follows it in a result is copied by words then, not byte by byte.
        #[repr(u32)]
        pub enum $codes {
            $(#[doc = $words] $name = $code,)*
        }

        impl $codes {
            /// All of them, by rising number.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// The number.
            pub const fn code(self) -> u8 {
                self as u8
            }

            /// The one with this number.
            pub fn from_code(code: u8) -> Option<Self> {
                Self::ALL.iter().copied().find(|one| one.code() == code)
            }

            const fn words(self) -> &'static str {
                match self {
                    $(Self::$name => $words),*
                }
            }
        }

        impl core::error::Error for $codes {}
    };
}

pub(crate) use codes;
