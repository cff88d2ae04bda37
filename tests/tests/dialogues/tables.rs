//! Compares the tables of docs/console.md with the code: each item in the code has a row.

use std::collections::BTreeSet;
use std::fs;

use isostep_console::{
    AlarmCode, Catalogue, Command, DoorPhase, Error, Realtime, ReportedState, SETTING_TABLE, Settings, realtime,
};
use isostep_profile::SpeedProfile;
use isostep_profile::shaper::{DAMPING_RATIO, NATURAL_HZ, ShaperKind};
use isostep_tests::root;

/// The rows of the table under a heading, as cells.
fn table(heading: &str) -> Vec<Vec<String>> {
    let page = fs::read_to_string(root().join("docs/console.md")).unwrap();
    let section = page.split("\n## ").find(|section| section.starts_with(heading)).expect(heading);
    let rows = section.lines().filter(|line| line.starts_with('|')).skip(2);
    let cells = |row: &str| row.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect();
    rows.map(cells).collect()
}

/// The first cells of the rows that do not say "never".
fn codes(heading: &str) -> BTreeSet<String> {
    table(heading).iter().filter(|row| !row[1].starts_with("never")).map(|row| row[0].replace('`', "")).collect()
}

#[test]
fn every_error_has_a_row() {
    let known: BTreeSet<_> = Error::ALL.iter().map(|error| error.code().to_string()).collect();
    assert_eq!(codes("Errors"), known);
}

#[test]
fn every_alarm_has_a_row() {
    let known: BTreeSet<_> = AlarmCode::ALL.iter().map(|alarm| alarm.code().to_string()).collect();
    assert_eq!(codes("Alarms"), known);
}

#[test]
fn every_state_has_a_row() {
    // The match is exhaustive, so a new state must be added here before this compiles.
    let next = |state| match state {
        ReportedState::Idle => Some(ReportedState::Run),
        ReportedState::Run => Some(ReportedState::Hold { stopping: false }),
        ReportedState::Hold { stopping: false } => Some(ReportedState::Hold { stopping: true }),
        ReportedState::Hold { stopping: true } => Some(ReportedState::Door(DoorPhase::Closed)),
        ReportedState::Door(DoorPhase::Closed) => Some(ReportedState::Door(DoorPhase::Open)),
        ReportedState::Door(DoorPhase::Open) => Some(ReportedState::Door(DoorPhase::Stopping)),
        ReportedState::Door(DoorPhase::Stopping) => Some(ReportedState::Door(DoorPhase::Resuming)),
        ReportedState::Door(DoorPhase::Resuming) => Some(ReportedState::Jog),
        ReportedState::Jog => Some(ReportedState::Home),
        ReportedState::Home => Some(ReportedState::Alarm),
        ReportedState::Alarm => Some(ReportedState::Check),
        ReportedState::Check => Some(ReportedState::Sleep),
        ReportedState::Sleep => Some(ReportedState::Tool),
        ReportedState::Tool => None,
    };
    let known: BTreeSet<_> =
        std::iter::successors(Some(ReportedState::Idle), |&state| next(state)).map(|state| state.to_string()).collect();
    assert_eq!(codes("States"), known);
}

#[test]
fn every_real_time_byte_has_a_row() {
    let name = |byte: u8| if byte.is_ascii_graphic() { char::from(byte).to_string() } else { format!("0x{byte:02X}") };
    let acts = |&byte: &u8| realtime::classify(byte).is_some_and(|realtime| realtime != Realtime::Ignored);
    let mut known: BTreeSet<_> = (0..=0xFF).filter(acts).map(name).collect();
    known.insert("others from 0x80 up".to_owned());
    assert_eq!(codes("Real-time bytes"), known);
}

/// The row of a command.
fn row(command: &Command<'_>) -> &'static str {
    match command {
        Command::Block(_) => "",
        Command::Jog(_) => "$J=",
        Command::Home { axis: None } => "$H",
        Command::Home { .. } => "$HX, $HY, $HZ",
        Command::Buzz { .. } => "$BUZZ=X, Y, Z",
        Command::MeasureStall { .. } => "$STALL=X, Y, Z",
        Command::Unlock => "$X",
        Command::MeasureTool => "$TPW",
        Command::SetToolReference => "$TLR",
        Command::ToggleCheck => "$C",
        Command::Sleep => "$SLP",
        Command::Boot => "$BOOT",
        Command::Prove { .. } => "$PROVE, $PROVE=...",
        Command::ShowDrivers => "M122",
        Command::ShowVfd => "$VFD",
        Command::Help => "$",
        Command::ShowSettings => "$$",
        Command::ShowParameters => "$#",
        Command::SetSetting { .. } => "$n=v",
        Command::Restore { settings: true, parameters: true } => "$RST=*",
        Command::Restore { settings: true, .. } => "$RST=$",
        Command::Restore { .. } => "$RST=#",
        Command::ShowBuild { is_extended: false } => "$I",
        Command::ShowBuild { .. } => "$I+",
        Command::ShowCatalogue(Catalogue::Settings) => "$ES",
        Command::ShowCatalogue(Catalogue::Groups) => "$EG",
        Command::ShowCatalogue(Catalogue::Errors) => "$EE",
        Command::ShowCatalogue(Catalogue::Alarms) => "$EA",
        Command::SetBuild { .. } => "$I=text",
        Command::ShowModal => "$G",
        Command::ShowStartup => "$N",
        Command::SetStartup { .. } => "$N0=line, $N1=line",
        Command::DescribeSetting { .. } => "$SED=n",
        Command::ExplainError(_) => "$En",
        Command::ExplainAlarm(_) => "$An",
    }
}

#[test]
fn every_command_has_a_row_with_its_states() {
    const ALL: [ReportedState; 10] = [
        ReportedState::Idle,
        ReportedState::Run,
        ReportedState::Hold { stopping: false },
        ReportedState::Door(DoorPhase::Closed),
        ReportedState::Jog,
        ReportedState::Home,
        ReportedState::Alarm,
        ReportedState::Check,
        ReportedState::Sleep,
        ReportedState::Tool,
    ];
    let lines = [
        "$", "$$", "$1=5", "$#", "$G", "$I", "$I+", "$I=A", "$N", "$N0=G21", "$C", "$TPW", "$TLR", "$X", "$H", "$HY",
        "$J=X1F1", "$BUZZ=Z", "$STALL=Y", "$SLP", "$BOOT", "$PROVE", "M122", "$VFD", "$RST=$", "$RST=#", "$RST=*",
        "$E1", "$A1", "$ES", "$SED=904", "$EG", "$EE", "$EA",
    ];
    let rows = table("`$` commands");
    assert_eq!(rows.len(), lines.len());
    for (line, cells) in lines.iter().zip(rows) {
        let mut taken = Vec::new();
        for state in ALL {
            let settings = isostep_console::Settings::DEFAULT;
            match isostep_console::Interpreter::new().interpret(line, state, &settings) {
                Ok(command) => {
                    assert_eq!(row(&command), cells[0].replace('`', ""));
                    taken.push(state);
                }
                Err(error) => assert_eq!(error, Error::NotIdle, "{line} in {state}"),
            }
        }
        let names = |states: &[ReportedState]| {
            let names = states.iter().map(|state| state.to_string().trim_end_matches(":0").to_owned());
            names.collect::<Vec<_>>().join(", ")
        };
        let refused: Vec<_> = ALL.into_iter().filter(|state| !taken.contains(state)).collect();
        let expected = match refused.len() {
            0 => "every".to_owned(),
            1..=2 => format!("every but {}", names(&refused)),
            _ => names(&taken),
        };
        assert_eq!(cells[2], expected, "{line}");
    }
}

#[test]
fn the_speed_profiles_of_the_settings_are_the_profiles() {
    let row = SETTING_TABLE.iter().find(|row| row.number == 940).unwrap();
    let names = (0..)
        .zip(SpeedProfile::ALL)
        .map(|(number, speed_profile)| format!("{number} {speed_profile}"))
        .collect::<Vec<_>>();
    assert_eq!(row.meaning(), format!("speed profile: {}", names.join(", ")));
    assert_eq!((row.min, row.max), (0.0, (SpeedProfile::ALL.len() - 1) as f32));
    for (number, speed_profile) in (0..).zip(SpeedProfile::ALL) {
        let settings = Settings { speed_profile: number, ..Settings::DEFAULT };
        assert_eq!(isostep_controller::config(&settings).speed_profile, speed_profile);
        // A speed profile over displacement cannot start from standstill.
        let refused = settings.check(&|_| f32::INFINITY).err().map(|conflict| conflict.to_string());
        let needs_start = format!(
            "$940={number} is a speed profile over displacement and never leaves standstill: raise $910 above 0, or lower $940"
        );
        assert_eq!(refused, speed_profile.is_over_displacement().then_some(needs_start), "{speed_profile}");
    }
}

#[test]
fn the_shapers_of_the_settings_are_the_profiles() {
    let row = |number| SETTING_TABLE.iter().find(|row| row.number == number).unwrap();
    let kinds = row(950);
    let name = |kind| match kind {
        ShaperKind::None | ShaperKind::Box => format!("{kind:?}").to_lowercase(),
        kind => format!("{kind:?}").to_uppercase(),
    };
    let names = (0..).zip(ShaperKind::ALL).map(|(number, kind)| format!("{number} {}", name(kind))).collect::<Vec<_>>();
    assert_eq!(kinds.meaning(), format!("shaper: {}", names.join(", ")));
    assert_eq!((kinds.min, kinds.max), (0.0, (ShaperKind::ALL.len() - 1) as f32));
    let range = |number| f64::from(row(number).min)..=f64::from(row(number).max);
    assert_eq!((range(960), range(970)), (NATURAL_HZ, DAMPING_RATIO));
}
