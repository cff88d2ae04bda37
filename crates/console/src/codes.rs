//! Numbered codes that senders know, each with a text of our own.

/// Defines an enum of such codes from a `pub enum` with entries of the form `Name = number, "text";`.
macro_rules! codes {
    ($(#[$doc:meta])* pub enum $codes:ident { $($name:ident = $code:literal, $words:literal;)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        // 32 bits: then the compiler copies what follows it in a `Result` word by word, not byte by byte.
        #[repr(u32)]
        pub enum $codes {
            $(#[doc = $words] $name = $code,)*
        }

        impl $codes {
            /// All codes, in ascending order.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// The number of this code.
            pub const fn code(self) -> u8 {
                self as u8
            }

            /// The code with this number.
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
