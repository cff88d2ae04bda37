//! Replaces the feeds of the lines of a program.

/// The highest speed of any machine, for timing programs at the machine's top speed.
const MAX_FEED: &[u8] = b"F12000";

/// Lines with F12000 in place of every F word. Comments are not changed.
pub fn at_max(lines: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(lines.len() + MAX_FEED.len());
    let mut rest = lines;
    let mut comment = None;
    while let [byte, after @ ..] = rest {
        rest = after;
        comment = match (comment, byte) {
            (None, b'(' | b';') => Some(*byte),
            (Some(b'('), b')') | (Some(_), b'\n' | b'\r') => None,
            _ => comment,
        };
        if comment.is_none() && matches!(byte, b'F' | b'f') {
            out.extend_from_slice(MAX_FEED);
            rest = behind_number(rest);
        } else {
            out.push(*byte);
        }
    }
    out
}

/// The text after a number and the blanks before it.
fn behind_number(text: &[u8]) -> &[u8] {
    let is_number = |byte: &u8| matches!(byte, b' ' | b'\t' | b'+' | b'-' | b'.' | b'0'..=b'9');
    let end = text.iter().position(|byte| !is_number(byte)).unwrap_or(text.len());
    // Blanks after the number belong to the text that follows.
    let blanks = text[..end].iter().rev().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    &text[end - blanks..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_feed_but_those_in_comments_is_replaced() {
        let rows = [
            ("G1 X1 F100 Y2\nG1X1f .5\n", "G1 X1 F12000 Y2\nG1X1F12000\n"),
            ("F1524.000", "F12000"),
            ("(F1) F2 ; F3\nF4(F5", "(F1) F12000 ; F3\nF12000(F5"),
            ("G0 X1\r\n", "G0 X1\r\n"),
        ];
        for (program, expected) in rows {
            assert_eq!(String::from_utf8(at_max(program.as_bytes())).unwrap(), expected);
        }
    }
}
