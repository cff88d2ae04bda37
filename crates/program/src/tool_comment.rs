//! The words of a program about the tool that it asks for. Whoever stands before the machine has to put in the right one, and a number says
//! little.

/// A line of a program that has M6.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ToolAsked {
    /// Its number in the file, from 1.
    pub line: usize,
    /// The number of the tool, the last one that T has named; 0 for none.
    pub tool: u32,
    /// The comment of the program about the tool.
    pub comment: Option<String>,
}

/// The lines with M6 in the order of the file, each with its tool.
pub fn tools_asked<L: AsRef<[u8]>>(source: &[L]) -> Vec<ToolAsked> {
    let (mut tool, mut asked) = (0, Vec::new());
    for (index, line) in source.iter().enumerate() {
        let line = Written::of(line.as_ref());
        tool = line.tool().unwrap_or(tool);
        if line.changes_tool() {
            asked.push(ToolAsked { line: index + 1, tool, comment: tool_comment(source, index, tool) });
        }
    }
    asked
}

/// True for a line that has M6, whatever else it has.
pub fn changes_tool(line: &[u8]) -> bool {
    Written::of(line).changes_tool()
}

/// The comment of a program about the tool that one of its lines asks for, M6 or only T; `None` if there is none. `index` is that of the
/// line, and `tool` its number, 0 for none.
///
/// It is, in this order: the comment of the line itself; the nearest one before it that names the tool, as `(T2 D=6 ...)`, `(TOOL 2: ...)`
/// or `(2 = ...)`; those directly before it, or the message directly behind it; and what the last comment behind the M6 before says of a
/// tool without a number. Comments that only say that a tool is changed count for nothing.
pub fn tool_comment<L: AsRef<[u8]>>(source: &[L], index: usize, tool: u32) -> Option<String> {
    let at = |index: usize| source.get(index).map_or_else(Written::default, |line| Written::of(line.as_ref()));
    let of_line = at(index).comments.iter().rev().find_map(|comment| telling(comment, tool));
    let named = || before(source, index).flat_map(|line| line.comments).find_map(|comment| about(&comment, tool));
    let of_part = || before(source, index).take_while(|line| !line.changes_tool());
    let directly_before = || {
        let near = of_part().take_while(|line| line.is_comment() || line.only_names_tool());
        near.flat_map(|line| line.comments).find_map(|comment| telling(&comment, tool))
    };
    let directly_behind =
        || at(index + 1).comments.iter().filter(|one| is_message(one)).find_map(|one| telling(one, tool));
    let of_any =
        || of_part().flat_map(|line| line.comments).filter(|one| is_of_tool(one)).find_map(|one| telling(&one, tool));
    of_line.or_else(named).or_else(directly_before).or_else(directly_behind).or_else(of_any)
}

/// The lines before one of them, the nearest first.
fn before<L: AsRef<[u8]>>(source: &[L], index: usize) -> impl Iterator<Item = Written> + '_ {
    source[..index.min(source.len())].iter().rev().map(|line| Written::of(line.as_ref()))
}

/// A line, its words parted from its comments.
#[derive(Default)]
struct Written {
    /// In upper case, without spaces.
    words: String,
    comments: Vec<String>,
}

impl Written {
    fn of(line: &[u8]) -> Self {
        let text = String::from_utf8_lossy(line);
        let (mut words, mut comments) = (String::new(), Vec::new());
        let mut rest = &*text;
        while let Some(start) = rest.find(['(', ';']) {
            words += &rest[..start];
            let is_whole_rest = rest[start..].starts_with(';');
            let comment = &rest[start + 1..];
            let end = if is_whole_rest { comment.len() } else { comment.find(')').unwrap_or(comment.len()) };
            comments.push(comment[..end].to_owned());
            rest = comment.get(end + 1..).unwrap_or_default();
        }
        words += rest;
        words.retain(|letter| !letter.is_whitespace());
        Self { words: words.to_uppercase(), comments }
    }

    fn is_comment(&self) -> bool {
        self.words.is_empty() && !self.comments.is_empty()
    }

    fn only_names_tool(&self) -> bool {
        self.words.strip_prefix('T').is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()))
    }

    /// The number behind T.
    fn tool(&self) -> Option<u32> {
        let (_, behind) = self.words.split_once('T')?;
        behind[..behind.bytes().take_while(u8::is_ascii_digit).count()].parse().ok()
    }

    fn changes_tool(&self) -> bool {
        self.words.split('M').skip(1).any(|behind| {
            let number = behind.trim_start_matches('0');
            number.starts_with('6') && !number[1..].starts_with(|next: char| next.is_ascii_digit() || next == '.')
        })
    }
}

fn is_message(comment: &str) -> bool {
    without_word(comment, "MSG").is_some()
}

fn is_of_tool(comment: &str) -> bool {
    without_word(without_message(comment), "TOOL").is_some()
}

/// The comment without `MSG,` before it, which is for the machine.
fn without_message(comment: &str) -> &str {
    without_word(comment, "MSG").map_or(comment, |rest| rest.trim_start_matches([',', ' ', ':']))
}

/// What follows this word, if the text begins with it.
fn without_word<'t>(text: &'t str, word: &str) -> Option<&'t str> {
    let text = text.trim_start();
    let (begins, rest) = (text.get(..word.len())?, text.get(word.len()..)?);
    let is_whole = !rest.starts_with(|next: char| next.is_alphanumeric());
    (begins.eq_ignore_ascii_case(word) && is_whole).then_some(rest)
}

/// What a comment says of this tool, if it begins with its number.
fn about(comment: &str, tool: u32) -> Option<String> {
    let (found, rest) = numbered(comment)?;
    if tool == 0 || found != tool { None } else { telling(rest, tool) }
}

/// The number of the tool with which a comment begins, and what is behind it: `T2 ...`, `TOOL 2: ...`, `Tool #2 ...` or `2 = ...`.
fn numbered(comment: &str) -> Option<(u32, &str)> {
    let comment = without_message(comment).trim_start();
    let behind_word = without_word(comment, "TOOL").map(|rest| rest.trim_start_matches([' ', ':', '#', '/', '-', '=']));
    let behind_letter = || comment.strip_prefix(['T', 't']).map(|rest| rest.trim_start_matches('#'));
    let of_word = behind_word.or_else(behind_letter);
    let text = of_word.unwrap_or(comment).trim_start_matches(['T', 't']);
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    let (number, rest) = text.split_at(digits);
    let is_whole = match of_word {
        Some(_) => !rest.starts_with(|next: char| next.is_alphanumeric() || next == '.'),
        None => rest.trim_start().starts_with('='),
    };
    is_whole.then(|| number.parse().ok()).flatten().map(|number| (number, rest))
}

/// A comment as it is shown: without the number that is known already. `None` if it says nothing, or is of another tool.
fn telling(comment: &str, tool: u32) -> Option<String> {
    let comment = without_message(comment);
    let rest = match numbered(comment) {
        Some((found, _)) if tool != 0 && found != tool => return None,
        Some((_, rest)) if tool != 0 => rest,
        _ => comment,
    };
    let words: Vec<_> = rest.split_whitespace().collect();
    let words = words.join(" ");
    let words = words.trim_matches([' ', ':', '=', '-', '|', ',', '>', ';']).to_owned();
    let says_something = words
        .split(|letter: char| !letter.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .any(|word| !OF_ANY_CHANGE.iter().any(|one| one.eq_ignore_ascii_case(word)));
    says_something.then_some(words)
}

/// Words of comments that hold for every tool, as in "Tool change" and "Select tool".
const OF_ANY_CHANGE: [&str; 15] = [
    "tool",
    "tools",
    "change",
    "toolchange",
    "select",
    "load",
    "the",
    "a",
    "new",
    "next",
    "list",
    "begin",
    "start",
    "for",
    "to",
];

#[cfg(test)]
mod tests {
    use super::{ToolAsked, changes_tool, tool_comment, tools_asked};

    /// The comment about the tool of the first line that has M6.
    fn found(text: &str, tool: u32) -> String {
        let lines: Vec<_> = text.lines().collect();
        let index = lines.iter().position(|line| line.contains("M6") || line.contains("M06")).unwrap();
        tool_comment(&lines, index, tool).unwrap_or_default()
    }

    #[test]
    fn fusion_lists_tools_at_the_top() {
        let text = "(1001)\n(T1 D=6. CR=0. - ZMIN=-26.75 - FLAT END MILL)\n(T15 D=3. CR=0. TAPER=90DEG - ZMIN=-1. - SPOT DRILL)\n\
            G90 G94\n(2D CONTOUR2)\nM9\nN25 T15 M6\n";
        assert_eq!(found(text, 15), "D=3. CR=0. TAPER=90DEG - ZMIN=-1. - SPOT DRILL");
        assert_eq!(found(&text.replace("T15 M6", "T1 G43 H1 M6"), 1), "D=6. CR=0. - ZMIN=-26.75 - FLAT END MILL");
        assert_eq!(
            found("(T2  D=5.1 CR=0. TAPER=118DEG - ZMIN=-18. - DRILL)\n(Drill1)\nT2 M6", 2),
            "D=5.1 CR=0. TAPER=118DEG - ZMIN=-18. - DRILL"
        );
    }

    #[test]
    fn vectric_has_a_list_or_a_comment_at_the_change() {
        let listed = "( Sign )\n(Tools used in this file: )\n(1 = End Mill {6 mm})\n(2 = V-Bit {90 deg 12 mm})\nG0Z20\nM5\nT2M6\n";
        assert_eq!(found(listed, 2), "V-Bit {90 deg 12 mm}");
        assert_eq!(found("(T1 = End Mill {6 mm})\n(T2 = V-Bit)\nT2\nM6\n", 2), "V-Bit");
        assert_eq!(found("G0 Z20\n(TOOL 2: V-Bit 60 deg)\nM05\nM6 T2\n", 2), "V-Bit 60 deg");
        assert_eq!(found("M5\n(Tool: End Mill {3 mm})\nG0 Z5\nM6 T4\n", 4), "Tool: End Mill {3 mm}");
    }

    #[test]
    fn flatcam_says_it_on_or_behind_the_line() {
        assert_eq!(
            found(
                "M5\nG00 Z15.0000\nT1\nG00 X0.0000 Y0.0000\nM6\n(MSG, Change to Tool Dia = 0.8000 ||| Total drills for tool T1 = 12)\nM0\n",
                1
            ),
            "Change to Tool Dia = 0.8000 ||| Total drills for tool T1 = 12"
        );
        assert_eq!(found("(TOOLS DIAMETER: )\n(Tool: 1 -> Dia: 0.8)\n(Tool: 2 -> Dia: 1.0)\nT2\nM6\n", 2), "Dia: 1.0");
        assert_eq!(found("M06 T03  ; 1.1000  \n", 3), "1.1000");
    }

    #[test]
    fn pcb2gcode_says_it_in_a_message() {
        let before = "G00 Z30 (Retract to tool change height)\nT1\nM5 (Spindle stop.)\n(MSG, Change tool bit to drill size 1.016mm)\nM6      (Tool change.)\n";
        assert_eq!(found(before, 1), "Change tool bit to drill size 1.016mm");
        let behind =
            "T0\nM6      ( Tool change.                 )\n(MSG, CHANGE TOOL BIT: to drill size 0.70000 mm)\nM0\n";
        assert_eq!(found(behind, 0), "CHANGE TOOL BIT: to drill size 0.70000 mm");
    }

    #[test]
    fn carbide_create_has_a_line_about_the_tool_before_its_number() {
        let text = "(STOCK/BLOCK,100.0,80.0)\nG90\nG21\n(TOOL/MILL,3.175, 0.000, 0.000, 0.00)\n(Move to safe Z)\nG0Z12.700\nM05\nM6 T102\n";
        assert_eq!(found(text, 102), "TOOL/MILL,3.175, 0.000, 0.000, 0.00");
    }

    #[test]
    fn estlcam_says_it_on_the_line_or_directly_before_it() {
        assert_eq!(found("(No. 2: Pocket 1)\nT2 M6 (Fräser 3 mm)\n", 2), "Fräser 3 mm");
        assert_eq!(found("M05\n(End mill 3mm)\nT2 M6\n", 2), "End mill 3mm");
    }

    #[test]
    fn other_programs_say_it_on_the_line_with_the_number_or_in_a_list() {
        assert_eq!(
            found("(T02 ID=002  DIA-0.5000   1/2 ENDMILL)\nM6 T02 (ID=002     1/2 Endmill)\n", 2),
            "ID=002 1/2 Endmill"
        );
        assert_eq!(found("M6 T7(TOOL DIA. 3)\n", 7), "TOOL DIA. 3");
        assert_eq!(
            found("G21\n(tool change to 6 mm Carbide Slot Cutter)\nT2 M06 G43\n", 2),
            "tool change to 6 mm Carbide Slot Cutter"
        );
        assert_eq!(found("; T3 = 60 degree cutter\nT3 M6\n", 3), "60 degree cutter");
        assert_eq!(found("(Tool #3 ball nose)\nT3 M6\n", 3), "ball nose");
    }

    #[test]
    fn each_line_with_m6_is_found_with_its_tool() {
        let asked = tools_asked(&["(T1 D=6)", "T1 M6", "T2 (next)", "G0 X1 (M6)", "m06 (V-bit)", "M61 Q3", "M60"]);
        let expected = [(2, 1, "D=6"), (5, 2, "V-bit")];
        let expected =
            expected.map(|(line, tool, comment)| ToolAsked { line, tool, comment: Some(comment.to_owned()) });
        assert_eq!(asked, expected);
        assert!(["T1 M6", "m06t2 (x)", "N5 M 6 G43 H1"].iter().all(|line| changes_tool(line.as_bytes())));
        assert!(["M61 Q1", "M60", "G0 X1 (M6)", "M5", "M6.5"].iter().all(|line| !changes_tool(line.as_bytes())));
    }

    #[test]
    fn what_says_nothing_of_this_tool_is_no_comment_about_it() {
        let of_others = [
            "T2 M6\n",
            "M06 T2 (Select tool)\n",
            "(Tool 2)\nT2 M6 (tool change)\n",
            "(T3 D=6)\nT2 M6\n",
            "(T20 D=6)\nT2 M6\n",
            "(T2.5 mm)\nG0 X1\nT2 M6\n",
            "(2D contour)\nG0 X1\nT2 M6\n",
        ];
        for text in of_others {
            assert_eq!(found(text, 2), "", "{text}");
        }
        assert_eq!(
            tool_comment(&["(Tool: old one)", "T1 M6", "G1 X1", "T2 M6"], 3, 2),
            None,
            "it is of the tool before"
        );
        assert_eq!(tool_comment::<&str>(&[], 3, 2), None);
    }
}
