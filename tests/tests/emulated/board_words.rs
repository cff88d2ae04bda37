//! The words of the board, which are written into an image that is linked.

use std::{env, fs};

use isostep_motion::LeastTimes;
use isostep_tests::emulated::{self, Board};
use object::{Object, ObjectSection};

#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn images_for_either_contact_differ_in_its_word_alone() {
    let read = |variable| fs::read(env::var_os(variable).expect("run these by `cargo xtask test`")).unwrap();
    let [open, closed] = ["ISOSTEP_ELF", "ISOSTEP_ESTOP_NC_ELF"].map(read);
    let elf = object::File::parse(&*open).unwrap();
    let (words, _) = elf.section_by_name(".board_words").and_then(|section| section.file_range()).unwrap();
    // Before it stand 8 bytes of magic, and the version.
    let contact = words as usize + 12;
    let differing: Vec<_> = (0..open.len()).filter(|&at| open[at] != closed[at]).collect();
    assert_eq!((open.len(), differing), (closed.len(), vec![contact]));
    assert_eq!([open[contact], closed[contact]], [0, 1]);
}

/// A DRV8825 takes 250,000 steps/s, and a TMC2209 more. The emulated drivers check every pulse.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn an_image_keeps_the_timing_of_the_drivers_that_its_word_says() {
    for (variable, driver, highest, refused) in
        [("ISOSTEP_ELF", "drv8825", 297_618, Some(297_619)), ("ISOSTEP_TMC2209_ELF", "tmc2209", 480_000, None)]
    {
        let mut script = "expect Grbl\nsend $120=100000\nexpect ok\n".to_owned();
        script.extend(refused.map(|rate| {
            format!("send $110={rate}\nexpect [MSG:$110={rate} is above the {highest} mm/min\nexpect ok\n")
        }));
        script += &format!("send $110={highest}\nexpect ok\nsend G91 G0 X800\nexpect ok\nwait-idle\ncheck-position\n");
        let run =
            Board::of_firmware(variable, &format!("board-words-{driver}")).with(&["--driver", driver]).script(&script);
        assert!(run.ok, "{}", run.printed);
        assert_eq!(run.figures["driver_timing"]["violations"], 0, "{}", run.printed);
        let shortest_ns = run.edges.windows(2).map(|edges| edges[1].t_ns - edges[0].t_ns).min().unwrap();
        let wanted_ns = 60_000_000_000 / (highest * 50);
        assert!(shortest_ns.abs_diff(wanted_ns) < 16, "{driver}: {shortest_ns} ns instead of {wanted_ns}");
    }
}

/// The place of the least times in an image: behind 8 bytes of magic and four words.
fn least_times_at(image: &[u8]) -> usize {
    let elf = object::File::parse(image).unwrap();
    elf.section_by_name(".board_words").and_then(|section| section.file_range()).unwrap().0 as usize + 24
}

/// How long each of 60 moves of a step lasts, straight on with G61 at a feed that no processor keeps, s, on a board with such an
/// image.
fn each_lasts_s(image: &[u8], name: &str) -> f64 {
    let mut script =
        "expect Grbl\nsend $120=10000\nexpect ok\nsend G61 G91 G1 F10000\nexpect ok\nsend G4 P0.3\n".to_owned();
    script += &"send X0.02\n".repeat(60);
    script += &"expect ok\n".repeat(61);
    let run = Board::new(&format!("least-times-{name}")).with_image(image).script(&(script + "wait-idle\n"));
    assert!(run.ok && run.edges.len() == 60, "{name}: {}", run.printed);
    (run.edges[50].t_ns - run.edges[10].t_ns) as f64 * 1e-9 / 40.0
}

/// The first of them is that of moves without a blend.
#[test]
#[ignore = "needs the firmware: cargo xtask test"]
fn an_image_makes_moves_last_as_long_as_its_words_say() {
    let linked = fs::read(env::var_os("ISOSTEP_ELF").expect("run these by `cargo xtask test`")).unwrap();
    let at = least_times_at(&linked);
    let times: Vec<f64> = linked[at..at + 64].as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let LeastTimes { straight_s, blend_s, join_s, together_s, shaped_s, box_s, box_root_step_s, queued_s, .. } =
        emulated::config().least_times;
    assert_eq!(times, [straight_s, blend_s, join_s, together_s, shaped_s, box_s, box_root_step_s, queued_s]);
    let each_s = |straight_s: f64, blend_s: f64, name: &str| {
        let mut image = linked.clone();
        image[at..at + 16].copy_from_slice(&[straight_s.to_le_bytes(), blend_s.to_le_bytes()].concat());
        each_lasts_s(&image, name)
    };
    let linked_s = each_s(straight_s, blend_s, "linked");
    let slower_s = each_s(2e-3, blend_s, "slower");
    let as_linked = 0.85 * straight_s..1e-3;
    assert!((slower_s / 2e-3 - 1.0).abs() < 1e-3 && as_linked.contains(&linked_s), "{slower_s} and {linked_s} s");
    // If one cannot be, none is in force, but those that it is linked with: so moves are as fast as the core reads them again.
    for (name, blend_s) in [("nan", f64::NAN), ("negative", -2e-3), ("endless", 1e300), ("none", 0.0)] {
        let lasts_s = each_s(2e-3, blend_s, name);
        assert!((lasts_s / linked_s - 1.0).abs() < 1e-3, "{name}: {lasts_s} s, not {linked_s}");
    }
}
