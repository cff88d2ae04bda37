//! The tool that M6 waits for, in words.

use isostep_program::tool_comment;
use isostep_sim::stream::asked_tool;

/// The tool that the machine has asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ToolWait {
    /// Its number, 0 if the program names none.
    tool: u32,
    /// The comment of the program about it.
    comment: Option<String>,
}

impl ToolWait {
    /// Reads the message of M6. The line that has it is the one with this index in `source`.
    pub fn read<L: AsRef<[u8]>>(message: &str, source: &[L], index: Option<usize>) -> Option<Self> {
        let tool = asked_tool(message.strip_prefix("[MSG:")?)?;
        let comment = index.and_then(|index| tool_comment(source, index, tool));
        Some(Self { tool, comment })
    }

    /// `tool 2: 6 mm end mill`.
    pub fn words(&self) -> String {
        let tool = if self.tool == 0 { "another tool".to_owned() } else { format!("tool {}", self.tool) };
        self.comment.as_ref().map_or(tool.clone(), |comment| format!("{tool}: {comment}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tool_is_named_with_the_comment_of_the_program() {
        let source = ["(T2 D=6 flat)", "T2 M6", "G0 X1"];
        let words = |message, index| ToolWait::read(message, &source, index).map(|wait| wait.words());
        let at_rest = "[MSG:M6: put in tool 2, then resume with ~]";
        assert_eq!(words(at_rest, Some(1)).as_deref(), Some("tool 2: D=6 flat"));
        assert_eq!(words(at_rest, None).as_deref(), Some("tool 2"));
        assert_eq!(words("[MSG:M6: put in tool 31, measure it ($TPW), then ~]", Some(1)).as_deref(), Some("tool 31"));
        assert_eq!(words("[MSG:M6: change the tool, then resume with ~]", None).as_deref(), Some("another tool"));
        assert_eq!(words("[MSG:M6: the tool was not measured ($TPW)]", Some(1)), None);
    }
}
