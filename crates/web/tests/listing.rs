//! A `$$` of another controller becomes what `isostep check --settings --write` writes, and what it prints is said.

use isostep_report::listing::Listing;
use isostep_sim::Config;
use isostep_web::listing::read;

const LISTINGS: [&str; 3] = [
    include_str!("../../report/tests/listings/skr-3-ez.txt"),
    include_str!("../../report/tests/listings/genmitsu-3018-pro.txt"),
    include_str!("../../report/tests/listings/fluidnc.txt"),
];

#[test]
fn a_listing_becomes_the_lines_that_the_tool_writes() {
    for text in LISTINGS {
        let (listing, listed) = (Listing::read("my.txt", text.as_bytes(), &Config::default()), read(text.as_bytes()));
        assert_eq!(listed.taken, Some(listing.text()));
        assert_eq!(listed.rows, listing.rows());
        assert!(listed.rows.iter().any(|row| !row.places.is_empty()));
    }
}

#[test]
fn what_does_not_work_together_is_not_taken() {
    let listed = read(b"$27=30\n$130=20\n");
    assert_eq!(listed.taken, None);
    let refused = listed.rows.iter().find(|row| row.name == "refused").unwrap();
    assert!(refused.places[0].contains("lower $27 or raise $130"), "{refused:?}");
}
