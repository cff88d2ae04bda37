//! `$` commands and reports: their answers, and the states in which they are allowed.

use super::talk::{Talk, carries};
use expect_test::{Expect, expect};
use isostep_console::{DoorPhase, ReportedState, SETTING_TABLE, Settings};

fn check(state: ReportedState, text: &str, heard: Expect) {
    heard.assert_eq(&Talk::new(state).send(text));
}

const COMMANDS: &str = "$\n$G\n$I\n$100=60\n$H\n$HY\n$HA\n$HXY\n$X\n$$$\n$#\n$N\n$C\n$SLP\n$BOOT\n$PROVE=READ, 0\n$J=X1\n$100\n$=1\n$X=1\n$+1=1\n$99999=1\n$999=1\n$0=\n$0=1E1\n$0=INF";

#[test]
fn commands_when_idle() {
    check(
        ReportedState::Idle,
        COMMANDS,
        expect![[r#"
            $ -> [HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x] [MSG:$En and $An explain a refusal or an alarm by its number n, $BUZZ=X moves X to and fro, $BOOT makes way for new firmware] ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            $I -> [VER:1.1h.20190830:Isostep 0.2.0 (grbl dialect)] [OPT:VNMZHL,79,128] ok
            $100=60 -> ok
            $H -> (home) ok
            $HY -> (home 1) ok
            $HA -> error:3
            $HXY -> error:3
            $X -> (unlock) ok
            $$$ -> error:3
            $# -> [G54:0.000,0.000,0.000] [G55:0.000,0.000,0.000] [G56:0.000,0.000,0.000] [G57:0.000,0.000,0.000] [G58:0.000,0.000,0.000] [G59:0.000,0.000,0.000] [G59.1:0.000,0.000,0.000] [G59.2:0.000,0.000,0.000] [G59.3:0.000,0.000,0.000] [G28:0.000,0.000,0.000] [G30:0.000,0.000,0.000] [G92:0.000,0.000,0.000] [TLO:0.000] [PRB:0.000,0.000,0.000:0] ok
            $N -> $N0= $N1= ok
            $C -> (check) ok
            $SLP -> (sleep) ok
            $BOOT -> (boot) ok
            $PROVE=READ, 0 -> (prove =READ,0) ok
            $J=X1 -> error:22
            $100 -> error:3
            $=1 -> error:3
            $X=1 -> error:3
            $+1=1 -> error:3
            $99999=1 -> error:3
            $999=1 -> [MSG:there is no $999: $$ lists the settings] error:3
            $0= -> error:2
            $0=1E1 -> error:2
            $0=INF -> error:2
        "#]],
    );
}

#[test]
fn commands_when_running() {
    check(
        ReportedState::Run,
        "$\n$G\n$I\n$100=60\n$H\n$BOOT\n$X\n$$\nX1",
        expect![[r#"
            $ -> [HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x] [MSG:$En and $An explain a refusal or an alarm by its number n, $BUZZ=X moves X to and fro, $BOOT makes way for new firmware] ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            $I -> error:8
            $100=60 -> error:8
            $H -> error:8
            $BOOT -> error:8
            $X -> (unlock) ok
            $$ -> error:8
            X1 -> (rapid [1.0, 0.0, 0.0]) ok
        "#]],
    );
}

#[test]
fn commands_when_the_door_was_opened() {
    let commands = "$\n$G\n$$\n$#\n$I\n$100=60\n$H\n$C\n$SLP\n$X\n$J=X1 F1\n$N0=G0\nM3 S1\nX1\nG38.2 Z-1 F1";
    let heard = [DoorPhase::Closed, DoorPhase::Open, DoorPhase::Stopping, DoorPhase::Resuming].map(|door| {
        assert!(!ReportedState::Door(door).at_rest());
        Talk::new(ReportedState::Door(door)).send(commands)
    });
    assert_eq!(heard, [(); 4].map(|()| Talk::new(ReportedState::Hold { stopping: false }).send(commands)));
    expect![[r#"
        $ -> [HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x] [MSG:$En and $An explain a refusal or an alarm by its number n, $BUZZ=X moves X to and fro, $BOOT makes way for new firmware] ok
        $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
        $$ -> error:8
        $# -> error:8
        $I -> error:8
        $100=60 -> error:8
        $H -> error:8
        $C -> error:8
        $SLP -> error:8
        $X -> (unlock) ok
        $J=X1 F1 -> error:8
        $N0=G0 -> error:8
        M3 S1 -> (spindle) (speed) ok
        X1 -> (rapid [1.0, 0.0, 0.0]) ok
        G38.2 Z-1 F1 -> (probe toward or alarm 1 [1.0, 0.0, -1.0]) ok
    "#]].assert_eq(&heard[0]);
}

#[test]
fn commands_in_alarm() {
    check(
        ReportedState::Alarm,
        "$\n$G\n$100=60\n$H\n$X\nX1",
        expect![[r#"
            $ -> [HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x] [MSG:$En and $An explain a refusal or an alarm by its number n, $BUZZ=X moves X to and fro, $BOOT makes way for new firmware] ok
            $G -> [GC:G0 G54 G17 G21 G90 G94 G64 M5 M9 T0 F0 S0] ok
            $100=60 -> ok
            $H -> (home) ok
            $X -> (unlock) ok
            X1 -> error:9
        "#]],
    );
}

#[test]
fn the_extended_build_says_what_is_true_here() {
    check(
        ReportedState::Idle,
        "$I+\n$I=MILL 3\n$22=0\n$I+\n$I++\n$+I",
        expect![[r#"
            $I+ -> [VER:1.1h.20190830:Isostep 0.2.0 (grbl dialect)] [OPT:VNMZHL,79,128,3,0] [AXS:3:XYZ] [NEWOPT:ENUMS,RT+,HOME,SED] [FIRMWARE:Isostep] [NVS STORAGE:FLASH] ok
            $I=MILL 3 -> ok
            $22=0 -> ok
            $I+ -> [VER:1.1h.20190830:MILL3] [OPT:VNMZHL,79,128,3,0] [AXS:3:XYZ] [MSG:Isostep 0.2.0 (grbl dialect)] [NEWOPT:ENUMS,RT+,SED] [FIRMWARE:Isostep] [NVS STORAGE:FLASH] ok
            $I++ -> error:3
            $+I -> error:3
        "#]],
    );
}

#[test]
fn catalogues_are_listed_where_settings_are_and_codes_are_explained_as_ever() {
    let commands = "$EG\n$ESX\n$E1\n$A1\n$AS\n$E\n$EA1";
    check(
        ReportedState::Alarm,
        commands,
        expect![[r#"
            $EG -> [SETTINGGROUP:1|0|Motors] [SETTINGGROUP:2|0|Axes] [SETTINGGROUP:3|0|Drivers] [SETTINGGROUP:4|0|Second motor] [SETTINGGROUP:5|0|Limits and homing] [SETTINGGROUP:6|0|How speed changes] [SETTINGGROUP:7|0|Corners and arcs] [SETTINGGROUP:8|0|Shapers] [SETTINGGROUP:9|0|Canned cycles] [SETTINGGROUP:10|0|Spindle and laser] [SETTINGGROUP:11|0|Change of the tool] [SETTINGGROUP:12|0|Probe and door] [SETTINGGROUP:13|0|Reports] ok
            $ESX -> error:3
            $E1 -> [MSG:A word must begin with a letter: remove the stray character.] ok
            $A1 -> [MSG:axis limit switch closed, steps may be lost: $X, move off it, then $H] ok
            $AS -> error:3
            $E -> error:3
            $EA1 -> error:3
        "#]],
    );
    let answers = |state| {
        ["$$", "$ES", "$EG", "$EE", "$EA"].map(|line| {
            let heard = Talk::new(state).bytes(format!("{line}\n").as_bytes());
            heard.rsplit(' ').next().map(str::to_owned)
        })
    };
    for state in ReportedState::ALL {
        let [settings, catalogues @ ..] = answers(state);
        assert!(catalogues.iter().all(|answer| *answer == settings), "{state}: {settings:?}, {catalogues:?}");
    }
}

#[test]
fn settings_print_as_grbl_prints_them() {
    let all = Talk::new(ReportedState::Idle).bytes(b"$$\n").replace(' ', "\n");
    let is_of_drivers = |line: &str| {
        let rows = SETTING_TABLE.iter().filter(|row| row.is_trinamic());
        rows.flat_map(|row| row.numbers()).any(|number| line.starts_with(&format!("${number}=")))
    };
    let heard = all.lines().filter(|line| !is_of_drivers(line)).collect::<Vec<_>>().join("\n");
    expect![[r#"
        $0=2
        $1=255
        $2=0
        $3=0
        $4=0
        $5=0
        $6=0
        $8=0
        $10=1
        $11=0.010
        $12=0.002
        $13=0
        $20=1
        $21=1
        $22=1
        $23=7
        $24=60.000
        $25=600.000
        $26=5
        $27=2.000
        $28=1.000
        $30=1000.000
        $31=0.000
        $32=0
        $33=5000.000
        $35=0.000
        $36=100.000
        $100=50.000
        $101=50.000
        $102=50.000
        $110=2880.000
        $111=2880.000
        $112=2880.000
        $120=50.000
        $121=50.000
        $122=50.000
        $130=350.000
        $131=400.000
        $132=100.000
        $170=0.000
        $171=0.000
        $172=0.000
        $340=5.000
        $341=0
        $342=30.000
        $343=25.000
        $344=200.000
        $349=10.000
        $374=2
        $375=50
        $394=0.000
        $395=0
        $461=60
        $462=8192
        $463=8193
        $464=8451
        $465=18
        $466=34
        $467=1
        $468=100.000
        $469=60.000
        $470=60.000
        $471=100.000
        $476=1
        $681=0
        $745=0
        $744=0
        $900=0
        $901=312
        $902=0
        $904=0.010
        $905=0
        $906=0.000
        $907=0
        $910=0.000
        $911=0.000
        $912=0.000
        $920=0.000
        $921=0.000
        $922=0.000
        $930=500.000
        $931=500.000
        $932=500.000
        $940=0
        $950=0
        $951=0
        $952=0
        $960=40.000
        $961=40.000
        $962=40.000
        $970=0.050
        $971=0.050
        $972=0.050
        ok"#]]
    .assert_eq(&heard);
}

#[test]
fn a_refused_setting_names_value_limit_and_remedy() {
    check(
        ReportedState::Idle,
        "$0=-1\n$0=2.5\n$2=8\n$20=2\n$22=0\n$20=1\n$22=1\n$H\n$27=0\n$11=-0.01\n$11=0\n$12=0\n$12=-1\n$12=200\n$100=-1\n$100=100000\n$102=5000\n$102=50\n$110=90000000\n$110=2880\n$0=200\n$901=311\n$901=321\n$911=3000\n$911=0\n$920=5\n$6=4\n$6=3\n$30=100001\n$30=100000\n$31=-1\n$31=99999.5\n$32=0.5\n$32=1\n$33=9\n$33=100001\n$33=1000\n$34=1\n$35=101\n$36=100.5\n$37=0\n$394=61\n$394=60\n$902=2\n$902=1",
        expect![[r#"
            $0=-1 -> [MSG:$0=-1 is negative: give 0 or more] error:4
            $0=2.5 -> [MSG:$0=2.500 is not a whole number: remove the fraction] error:23
            $2=8 -> [MSG:$2=8 is above the most, 0: lower it] error:2
            $20=2 -> [MSG:$20=2 is above the most, 1: lower it] error:2
            $22=0 -> ok
            $20=1 -> [MSG:$20=1 needs a machine that homes: set $22=1 or $20=0; until then nothing moves] ok
            $22=1 -> ok
            $H -> (home) ok
            $27=0 -> [MSG:$27=0 is below the least, 0.100 mm: raise it] error:2
            $11=-0.01 -> [MSG:$11=-0.010 is negative: give 0 or more] error:4
            $11=0 -> ok
            $12=0 -> [MSG:$12=0 is below the least, 0.001 mm: raise it] error:2
            $12=-1 -> [MSG:$12=-1 is negative: give 0 or more] error:4
            $12=200 -> [MSG:$12=200 is above the most, 100 mm: lower it] error:2
            $100=-1 -> [MSG:$100=-1 is negative: give 0 or more] error:4
            $100=100000 -> [MSG:$100=100000 is above the most, 10000 steps/mm: lower it] error:2
            $102=5000 -> [MSG:$112=2880 is above the 360 mm/min that the step outputs carry with $0=2 at $102=5000 steps/mm: lower one of the three; until then nothing moves] ok
            $102=50 -> ok
            $110=90000000 -> [MSG:$110=90000000 is above the 36000 mm/min that the step outputs carry with $0=2 at $100=50 steps/mm: lower one of the three; until then nothing moves] ok
            $110=2880 -> ok
            $0=200 -> [MSG:$0=200 is above the most, 20 us: lower it] error:2
            $901=311 -> [MSG:$901=311 is no order: give each of 1 (X), 2 (Y) and 3 (Z) once, as in 312] error:2
            $901=321 -> ok
            $911=3000 -> [MSG:$911=3000 is above the top speed, $111=2880 mm/min: lower $911 or raise $111; until then nothing moves] ok
            $911=0 -> ok
            $920=5 -> ok
            $6=4 -> [MSG:$6=4 is above the most, 3: lower it] error:2
            $6=3 -> ok
            $30=100001 -> [MSG:$30=100001 is above the most, 100000 rpm: lower it] error:2
            $30=100000 -> ok
            $31=-1 -> [MSG:$31=-1 is negative: give 0 or more] error:4
            $31=99999.5 -> ok
            $32=0.5 -> [MSG:$32=0.500 is not a whole number: remove the fraction] error:23
            $32=1 -> ok
            $33=9 -> [MSG:$33=9 is below the least, 10 Hz: raise it] error:2
            $33=100001 -> [MSG:$33=100001 is above the most, 100000 Hz: lower it] error:2
            $33=1000 -> ok
            $34=1 -> [MSG:there is no $34: $$ lists the settings] error:3
            $35=101 -> [MSG:$35=101 is above the most, 100 %: lower it] error:2
            $36=100.5 -> [MSG:$36=100.500 is above the most, 100 %: lower it] error:2
            $37=0 -> [MSG:there is no $37: $$ lists the settings] error:3
            $394=61 -> [MSG:$394=61 is above the most, 60 s: lower it] error:2
            $394=60 -> ok
            $902=2 -> [MSG:$902=2 is above the most, 1: lower it] error:2
            $902=1 -> ok
        "#]],
    );
}

/// They are kept, and nothing moves before they work together. The rule holds whether the pull-off or the travel is changed.
#[test]
fn a_pull_off_is_below_the_travel_of_every_axis() {
    check(
        ReportedState::Idle,
        "$27=100\n$27=99.5\n$132=99.5\n$131=50\n$132=99.6\n$132=1\n$27=0.5\n$132=1\n$27=1",
        expect![[r#"
            $27=100 -> [MSG:$27=100 is not below the travel of Z, $132=100 mm: lower $27 or raise $132; until then nothing moves] ok
            $27=99.5 -> ok
            $132=99.5 -> [MSG:$27=99.500 is not below the travel of Z, $132=99.500 mm: lower $27 or raise $132; until then nothing moves] ok
            $131=50 -> [MSG:$27=99.500 is not below the travel of Y, $131=50 mm: lower $27 or raise $131; until then nothing moves] ok
            $132=99.6 -> [MSG:$27=99.500 is not below the travel of Y, $131=50 mm: lower $27 or raise $131; until then nothing moves] ok
            $132=1 -> [MSG:$27=99.500 is not below the travel of Y, $131=50 mm: lower $27 or raise $131; until then nothing moves] ok
            $27=0.5 -> ok
            $132=1 -> ok
            $27=1 -> [MSG:$27=1 is not below the travel of Z, $132=1 mm: lower $27 or raise $132; until then nothing moves] ok
        "#]],
    );
}

#[test]
fn least_speed_and_duty_are_not_above_full() {
    check(
        ReportedState::Idle,
        "$31=1000\n$31=1000.5\n$31=999\n$30=999\n$30=500\n$30=1000.5\n$31=0\n$30=0\n$30=0.5\n$35=60\n$36=59.5\n$36=60\n$35=60.001\n$36=100\n$35=100\n$35=100.5",
        expect![[r#"
            $31=1000 -> [MSG:$31=1000 is not below the S at full duty, $30=1000 rpm: lower $31 or raise $30; until then nothing moves] ok
            $31=1000.5 -> [MSG:$31=1000.500 is not below the S at full duty, $30=1000 rpm: lower $31 or raise $30; until then nothing moves] ok
            $31=999 -> ok
            $30=999 -> [MSG:$31=999 is not below the S at full duty, $30=999 rpm: lower $31 or raise $30; until then nothing moves] ok
            $30=500 -> [MSG:$31=999 is not below the S at full duty, $30=500 rpm: lower $31 or raise $30; until then nothing moves] ok
            $30=1000.5 -> ok
            $31=0 -> ok
            $30=0 -> [MSG:$31=0 is not below the S at full duty, $30=0 rpm: lower $31 or raise $30; until then nothing moves] ok
            $30=0.5 -> ok
            $35=60 -> ok
            $36=59.5 -> [MSG:$35=60 is above the duty at $30, $36=59.500 %: lower $35 or raise $36; until then nothing moves] ok
            $36=60 -> ok
            $35=60.001 -> [MSG:$35=60.001 is above the duty at $30, $36=60 %: lower $35 or raise $36; until then nothing moves] ok
            $36=100 -> ok
            $35=100 -> ok
            $35=100.5 -> [MSG:$35=100.500 is above the most, 100 %: lower it] error:2
        "#]],
    );
}

#[test]
fn a_speed_profile_over_displacement_needs_a_start_speed_on_every_axis() {
    check(
        ReportedState::Idle,
        "$940=2\n$940=3\n$910=120\n$940=6\n$911=120\n$912=120\n$940=6\n$912=0\n$940=0\n$912=0",
        expect![[r#"
            $940=2 -> ok
            $940=3 -> [MSG:$940=3 is a speed profile over displacement and never leaves standstill: raise $910 above 0, or lower $940; until then nothing moves] ok
            $910=120 -> [MSG:$940=3 is a speed profile over displacement and never leaves standstill: raise $911 above 0, or lower $940; until then nothing moves] ok
            $940=6 -> [MSG:$940=6 is a speed profile over displacement and never leaves standstill: raise $911 above 0, or lower $940; until then nothing moves] ok
            $911=120 -> [MSG:$940=6 is a speed profile over displacement and never leaves standstill: raise $912 above 0, or lower $940; until then nothing moves] ok
            $912=120 -> ok
            $940=6 -> ok
            $912=0 -> [MSG:$940=6 is a speed profile over displacement and never leaves standstill: raise $912 above 0, or lower $940; until then nothing moves] ok
            $940=0 -> ok
            $912=0 -> ok
        "#]],
    );
}

#[test]
fn a_refused_speed_profile_or_jerk_names_value_limit_and_remedy() {
    check(
        ReportedState::Idle,
        "$940=7\n$940=1.5\n$940=-1\n$930=-1\n$932=0\n$933=1",
        expect![[r#"
        $940=7 -> [MSG:$940=7 is above the most, 6: lower it] error:2
        $940=1.5 -> [MSG:$940=1.500 is not a whole number: remove the fraction] error:23
        $940=-1 -> [MSG:$940=-1 is negative: give 0 or more] error:4
        $930=-1 -> [MSG:$930=-1 is negative: give 0 or more] error:4
        $932=0 -> ok
        $933=1 -> [MSG:there is no $933: $$ lists the settings] error:3
    "#]],
    );
}

#[test]
fn a_refused_shaper_names_value_limit_and_remedy() {
    check(
        ReportedState::Idle,
        "$950=6\n$951=1.5\n$952=-1\n$950=5\n$960=9.9\n$960=10\n$961=500.5\n$961=500\n$962=-40\n$970=0.51\n$970=0.5\n$971=-0.1\n$972=0\n$953=1",
        expect![[r#"
            $950=6 -> [MSG:$950=6 is above the most, 5: lower it] error:2
            $951=1.5 -> [MSG:$951=1.500 is not a whole number: remove the fraction] error:23
            $952=-1 -> [MSG:$952=-1 is negative: give 0 or more] error:4
            $950=5 -> ok
            $960=9.9 -> [MSG:$960=9.900 is below the least, 10 Hz: raise it] error:2
            $960=10 -> ok
            $961=500.5 -> [MSG:$961=500.500 is above the most, 500 Hz: lower it] error:2
            $961=500 -> ok
            $962=-40 -> [MSG:$962=-40 is negative: give 0 or more] error:4
            $970=0.51 -> [MSG:$970=0.510 is above the most, 0.500: lower it] error:2
            $970=0.5 -> ok
            $971=-0.1 -> [MSG:$971=-0.100 is negative: give 0 or more] error:4
            $972=0 -> ok
            $953=1 -> [MSG:there is no $953: $$ lists the settings] error:3
        "#]],
    );
}

/// Whichever of the two comes first.
#[test]
fn a_shaper_and_a_curved_speed_profile_refuse_each_other() {
    check(
        ReportedState::Idle,
        "$940=2\n$950=1\n$960=35\n$940=0\n$951=1\n$940=2\n$950=3\n$940=1\n$950=0\n$951=0\n$940=1",
        expect![[r#"
            $940=2 -> ok
            $950=1 -> [MSG:$950=1 and $940=2 do not work together, as only the trapezoid is shaped: set $950=0 or $940=0; until then nothing moves] ok
            $960=35 -> [MSG:$950=1 and $940=2 do not work together, as only the trapezoid is shaped: set $950=0 or $940=0; until then nothing moves] ok
            $940=0 -> ok
            $951=1 -> ok
            $940=2 -> [MSG:$950=1 and $940=2 do not work together, as only the trapezoid is shaped: set $950=0 or $940=0; until then nothing moves] ok
            $950=3 -> [MSG:$950=3 and $940=2 do not work together, as only the trapezoid is shaped: set $950=0 or $940=0; until then nothing moves] ok
            $940=1 -> [MSG:$950=3 and $940=1 do not work together, as only the trapezoid is shaped: set $950=0 or $940=0; until then nothing moves] ok
            $950=0 -> [MSG:$951=1 and $940=1 do not work together, as only the trapezoid is shaped: set $951=0 or $940=0; until then nothing moves] ok
            $951=0 -> ok
            $940=1 -> ok
        "#]],
    );
}

#[test]
fn homing_switched_off_refuses_to_home_and_drops_soft_limits() {
    let mut talk = Talk::new(ReportedState::Idle);
    assert_eq!(talk.bytes(b"$22=0\n$H\n"), "ok error:5");
    assert!(!talk.settings.soft_limits);
}

#[test]
fn the_highest_rate_named_is_accepted() {
    for (pulse_us, steps_per_mm) in [(2, 50.0), (3, 33.3), (20, 999.9), (17, 0.7)] {
        let settings = Settings { pulse_us, steps_per_mm: [steps_per_mm; 3], ..Settings::DEFAULT };
        let settings = Settings { max_rate_mm_min: [60.0; 3], ..settings };
        let words = settings.with(110, 9e7).unwrap().check(&carries).unwrap_err().to_string();
        let most = words.split("above the ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
        assert_eq!(settings.with(110, most.parse().unwrap()).unwrap().check(&carries), Ok(()));
    }
}

#[test]
fn what_is_printed_can_be_sent_back() {
    let mut sent = Talk::new(ReportedState::Idle);
    sent.send("$0=10\n$3=5\n$6=2\n$22=0\n$27=1.235\n$30=24000\n$31=0.5\n$32=1\n$33=20000\n$35=5.5\n$36=60\n$394=1.25\n$902=1\n$11=0\n$12=0.05\n$101=80.125\n$121=0.1\n$131=9999.999\n$900=1\n$901=213\n$922=7\n$931=1234.5\n$940=1");
    let listing = sent.bytes(b"$$\n");
    let mut restored = Talk::new(ReportedState::Alarm);
    for line in listing.split(' ').filter(|line| line.starts_with('$')) {
        assert_eq!(restored.bytes(format!("{line}\n").as_bytes()), "ok", "{line}");
    }
    assert_eq!(restored.settings, sent.settings);
}

#[test]
fn the_table_is_in_order_and_the_defaults_are_in_range() {
    // But for the microsteps, which the steps follow: a listing that is sent back ends with the steps that it says. And no drive
    // seems to be in alarm in between.
    let sorted = SETTING_TABLE.iter().filter(|row| ![150, 745].contains(&row.number));
    assert!(sorted.is_sorted_by(|a, b| a.numbers().end <= b.number));
    let place = |number| SETTING_TABLE.iter().position(|row| row.number == number);
    assert!(place(150) < place(100) && place(745) < place(744));
    for number in SETTING_TABLE.iter().flat_map(|row| row.numbers()) {
        let value = Settings::DEFAULT.get(number).unwrap();
        assert_eq!(Settings::DEFAULT.with(number, value), Ok(Settings::DEFAULT), "${number}");
    }
    assert_eq!(Settings::DEFAULT.homing_order(), [2, 0, 1].map(Some));
    assert_eq!(Settings { decel_or_0_mm_s2: [0.0, 9.0, 0.0], ..Settings::DEFAULT }.decel_mm_s2(), [50.0, 9.0, 50.0]);
}
