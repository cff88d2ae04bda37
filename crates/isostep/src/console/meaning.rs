//! The meanings of error and alarm codes.

use isostep_console::{AlarmCode, Error};

/// The line as it is printed. If it has an error or alarm code that Isostep knows, its meaning is added.
pub fn explained(line: &str) -> String {
    let error = || Some(Error::from_code(number(line, "error:")?)?.to_string());
    let alarm = || Some(AlarmCode::from_code(number(line, "ALARM:")?)?.to_string());
    error().or_else(alarm).map_or_else(|| line.to_owned(), |words| format!("{line}  {words}"))
}

fn number(line: &str, word: &str) -> Option<u8> {
    line.strip_prefix(word)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::explained;

    #[test]
    fn numbers_have_their_words() {
        assert!(explained("error:9").starts_with("error:9  G-code is locked out in Alarm"));
        assert!(explained("ALARM:1").starts_with("ALARM:1  axis limit switch closed"));
        assert_eq!(explained("error:250"), "error:250");
        assert_eq!(explained("[MSG:error:9]"), "[MSG:error:9]");
    }
}
