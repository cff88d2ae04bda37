//! The words of the board, which are written into an image that is linked.

use std::{env, fs};

use isostep_tests::emulated::Board;
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
