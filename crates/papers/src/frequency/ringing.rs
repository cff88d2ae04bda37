//! Fonseca-Campos's Table 7 and figure 13 compared with the model's: how much each profile rings, when most, and which has the
//! most power.

use crate::welch::Spectrum;
use anyhow::Result;
use isostep_generators::FrequencyRamp;
use isostep_report::pictures::chart::{self, Axis, Chart, Curve, Scale};
use isostep_report::pictures::document::{Picture, Table};
use isostep_report::pictures::theme::CURVE;
use isostep_sim::analysis::Oscillator;

use super::figures::key;
use super::parameters::TABLE_6;
use super::vibration::{
    DAMPING_RATIO, Drive, SAMPLE_HZ, deviation, drive, fine_deviation, instants_s, spectrum, waveforms, without_jumps,
};
use crate::row::{Paper, Row};

/// Standard deviations of Table 7, m/s², in the order of [`FrequencyRamp::ALL`].
const TABLE_7: [f64; 4] = [0.025, 0.026, 0.022, 0.088];
/// The paper's ratios of these to the sinusoidal profile's (section VI.F).
const TIMES: [f64; 4] = [1.13, 1.18, 1.0, 4.0];
/// Index of the sinusoidal profile.
const LEAST: usize = 2;
/// The middle of the band in which the paper saw the most power, Hz.
const MIDDLE_HZ: f64 = 45.0;

/// One profile in the model.
struct Modelled {
    frequency_ramp: FrequencyRamp,
    drive: Drive,
    /// Standard deviation, m/s², of a carriage whose coupling is scaled so that the sinusoidal profile gives its value in
    /// Table 7.
    deviation: f64,
    /// The standard deviation as a multiple of the sinusoidal profile's.
    times: f64,
    /// The same multiple without the jumps to and from the start speed.
    times_without_jumps: f64,
}

/// All four profiles, and the scale of the model: m/s² per step/s².
fn model() -> Result<(Vec<Modelled>, f64)> {
    let drives = FrequencyRamp::ALL.map(drive).into_iter().collect::<Result<Vec<_>>>()?;
    let of = |each: &dyn Fn(&Drive) -> Result<f64>| drives.iter().map(each).collect::<Result<Vec<_>>>();
    let (with, without) = (of(&deviation)?, of(&|drive| deviation(&without_jumps(drive)))?);
    let scale = TABLE_7[LEAST] / with[LEAST];
    let frequency_ramps = FrequencyRamp::ALL.into_iter().zip(drives).enumerate();
    let modelled = frequency_ramps.map(|(index, (frequency_ramp, drive))| Modelled {
        frequency_ramp,
        drive,
        deviation: with[index] * scale,
        times: with[index] / with[LEAST],
        times_without_jumps: without[index] / without[LEAST],
    });
    Ok((modelled.collect(), scale))
}

/// Rows for the order, the multiples and the standard deviations.
pub fn rows() -> Result<Vec<Row>> {
    let (frequency_ramps, _) = model()?;
    let mut ordered: Vec<&Modelled> = frequency_ramps.iter().collect();
    ordered.sort_by(|one, other| one.times.total_cmp(&other.times));
    let found =
        ordered.iter().map(|frequency_ramp| frequency_ramp.frequency_ramp.name()).collect::<Vec<_>>().join(" < ");
    let says = "sinusoidal < linear < quadratic < logarithmic";
    let ask = Paper::Frequency.asks("VI.F, Table 7", "residual vibration, Table 6 (a model)");
    let mut rows = vec![ask.says(says, &found, found == says)];
    for (index, frequency_ramp) in frequency_ramps.iter().enumerate().filter(|(index, _)| *index != LEAST) {
        let ask = |quantity: String| Paper::Frequency.asks("VI.F, Table 7", quantity);
        let times = format!("vibration of {}, of the sinusoidal profile's (a model)", frequency_ramp.frequency_ramp);
        rows.push(ask(times).number("times", 2).printed(TIMES[index], frequency_ramp.times));
        let deviation =
            format!("deviation of {}, scaled to sinusoidal = 0.022 (a model)", frequency_ramp.frequency_ramp);
        rows.push(ask(deviation).number("m/s2", 3).printed(TABLE_7[index], frequency_ramp.deviation));
    }
    rows.extend([second_peak()?, greatest_power()?]);
    Ok(rows)
}

/// When a profile's deceleration begins and its move ends, with the parameters of Table 6, s.
struct Phases {
    decel_s: f64,
    end_s: f64,
}

fn phases(frequency_ramp: FrequencyRamp) -> Result<Phases> {
    let profile = TABLE_6.exact(frequency_ramp)?;
    let first_decelerating = (profile.steps() - profile.ramp_steps()) as usize - 1;
    let decel_s = profile.edges_s().nth(first_decelerating).unwrap_or(0.0);
    Ok(Phases { decel_s, end_s: profile.duration_s() })
}

/// When the vibration is greatest in the second half of the move and after it, s.
fn peak_s(frequency_ramp: FrequencyRamp) -> Result<f64> {
    let end_s = phases(frequency_ramp)?.end_s;
    let instants: Vec<f64> =
        (0..).map(|n| end_s / 2.0 + f64::from(n) * 1e-4).take_while(|t_s| *t_s < end_s + 0.3).collect();
    let readings = Oscillator::new(MIDDLE_HZ, DAMPING_RATIO)?.ring(&drive(frequency_ramp)?, &instants);
    let greatest = readings.iter().zip(&instants).max_by(|one, other| one.0.abs().total_cmp(&other.0.abs()));
    Ok(greatest.map_or(0.0, |(_, t_s)| *t_s))
}

fn second_peak() -> Result<Row> {
    let frequency_ramp = FrequencyRamp::Logarithmic;
    let (peak_s, Phases { decel_s, end_s }) = (peak_s(frequency_ramp)?, phases(frequency_ramp)?);
    let agrees = (peak_s - decel_s).abs() < (peak_s - end_s).abs();
    let found = format!("at {peak_s:.2} s, when the move ends; it decelerates from {decel_s:.2} s on");
    let ask = Paper::Frequency.asks("VI.F, figure 13", "second peak of the logarithmic profile's vibration (a model)");
    Ok(ask.says("when the deceleration begins", found, agrees))
}

fn greatest_power() -> Result<Row> {
    let mut peaks = Vec::new();
    for frequency_ramp in FrequencyRamp::ALL {
        peaks.push((frequency_ramp, spectrum(&drive(frequency_ramp)?)?.densities.into_iter().fold(0.0, f64::max)));
    }
    let greatest = peaks.iter().max_by(|one, other| one.1.total_cmp(&other.1)).copied();
    let least = peaks.iter().map(|peak| peak.1).fold(f64::MAX, f64::min);
    let (frequency_ramp, peak) = greatest.unwrap_or((FrequencyRamp::Linear, 0.0));
    let found = format!("{frequency_ramp}: {:.1} times the lowest profile's", peak / least);
    let ask = Paper::Frequency.asks("VI.F, figure 13", "highest power spectral density (a model)");
    Ok(ask.says("logarithmic", found, frequency_ramp == FrequencyRamp::Logarithmic))
}

/// The multiples with and without the jumps.
pub fn table() -> Result<Table> {
    let (frequency_ramps, _) = model()?;
    let rows = frequency_ramps.iter().zip(TIMES).map(|(frequency_ramp, printed)| {
        let times =
            [printed, frequency_ramp.times, frequency_ramp.times_without_jumps].map(|times| format!("{times:.2}"));
        [frequency_ramp.frequency_ramp.name().to_owned()].into_iter().chain(times).collect()
    });
    let head = ["profile", "paper", "model", "model, ramps alone"];
    let caption = "Standard deviation as a multiple of the sinusoidal profile's";
    Ok(Table::new(&head, rows.collect()).captioned(caption))
}

/// Figure 13, and how the result depends on the natural frequency.
pub fn pictures() -> Result<Vec<Picture>> {
    let (frequency_ramps, scale) = model()?;
    Ok(vec![
        waveform_picture(&frequency_ramps, scale)?,
        spectrum_picture(&frequency_ramps, scale)?,
        sweep_picture(&frequency_ramps)?,
    ])
}

fn waveform_picture(frequency_ramps: &[Modelled], scale: f64) -> Result<Picture> {
    let oscillator = Oscillator::new(MIDDLE_HZ, DAMPING_RATIO)?;
    let one = |(colour, frequency_ramp): (usize, &Modelled)| {
        let readings = waveforms(&frequency_ramp.drive, &oscillator);
        let points = instants_s().zip(&readings[0]).map(|(t_s, reading)| (t_s, reading * scale));
        let y = Axis::from(format!("{}, m/s²", frequency_ramp.frequency_ramp)).within(-0.25, 0.25);
        Chart::new("time, s", y, vec![Curve::line(CURVE[colour], points)])
    };
    let panels: Vec<Chart> = frequency_ramps.iter().enumerate().map(one).collect();
    Ok(Picture::new(
        "fonseca-campos-2023-figure-13-time",
        chart::picture("Modelled vibration of the four profiles of Table 6 over time", &[], 2, 240, &panels),
        "Figure 13, in the model: what a sensor on the carriage reads, 180 samples of 10 ms, here of a carriage of \
         45 Hz. It rings when the move begins, where the paper has its first peak: the speed jumps to tau_max's \
         whatever the profile, and the logarithmic profile adds a jolt of its own. Its second peak is where the move ends, \
         for the same reason; the paper puts it where the deceleration begins.",
    ))
}

fn spectrum_picture(frequency_ramps: &[Modelled], scale: f64) -> Result<Picture> {
    let mut curves = Vec::new();
    for (colour, frequency_ramp) in frequency_ramps.iter().enumerate() {
        let Spectrum { frequencies_hz, densities } = spectrum(&frequency_ramp.drive)?;
        let points = frequencies_hz.into_iter().zip(densities).skip(1);
        let points = points.map(|(hz, density)| (hz, density * scale * scale));
        curves.push(Curve::line(CURVE[colour], points));
    }
    let chart = Chart::new("frequency, Hz", Axis::scaled("(m/s²)²/Hz", Scale::Logarithmic), curves);
    Ok(Picture::new(
        "fonseca-campos-2023-figure-13-spectrum",
        chart::picture("Power spectral density of the modelled vibration", &key(), 1, 320, &[chart]),
        format!(
            "Figure 13, in the model: power spectral density by Welch's method with SciPy's defaults at {SAMPLE_HZ:.0} \
             samples a second, the mean over carriages of 40 to 50 Hz and ten waveforms of each. That the power stands \
             at 40 to 50 Hz is put in, not found; how much of it each profile wakes is found."
        ),
    ))
}

fn sweep_picture(frequency_ramps: &[Modelled]) -> Result<Picture> {
    let frequencies = || (10..=100).map(f64::from);
    let all = |frequency_ramp: &Modelled| {
        frequencies().map(|hz| fine_deviation(&frequency_ramp.drive, hz)).collect::<Result<Vec<_>>>()
    };
    let least = all(&frequency_ramps[LEAST])?;
    let mut curves = Vec::new();
    for (colour, frequency_ramp) in frequency_ramps.iter().enumerate() {
        let times = all(frequency_ramp)?.into_iter().zip(&least).map(|(deviation, least)| deviation / least);
        curves.push(Curve::line(CURVE[colour], frequencies().zip(times)));
    }
    let chart = Chart::new("natural frequency of the carriage, Hz", "times the sinusoidal profile's", curves);
    Ok(Picture::new(
        "fonseca-campos-2023-natural-frequency",
        chart::picture("Vibration over the natural frequency of the carriage", &key(), 1, 320, &[chart]),
        "The same moves on carriages of 10 to 100 Hz. The logarithmic profile rings most up to about 75 Hz; the paper's four \
         times is what carriages of some 15 to 25 Hz have. Above, a period is as short as its first few steps, and \
         its jolt comes half a period after the jump to the start speed and works against it. Where the ringing of \
         one ramp's end meets that of its beginning they add up or cancel, from hertz to hertz: the linear profile is now \
         above, now below the sinusoidal one, so it is the mean over a band that is compared.",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Cell;

    #[test]
    fn the_order_is_the_papers() {
        assert_eq!(rows().unwrap()[0].difference, Cell::Words("none".to_owned()));
    }

    #[test]
    fn table_7_is_what_the_multiples_say() {
        for (deviation, times) in TABLE_7.into_iter().zip(TIMES) {
            assert!((deviation / TABLE_7[LEAST] - times).abs() < 0.01);
        }
    }

    /// Every profile stops abruptly from its start speed, which excites more vibration than any profile's deceleration.
    #[test]
    fn every_frequency_ramp_rings_most_when_it_stops() {
        for frequency_ramp in FrequencyRamp::ALL {
            let (peak_s, Phases { decel_s, end_s }) =
                (peak_s(frequency_ramp).unwrap(), phases(frequency_ramp).unwrap());
            assert!(decel_s < end_s - 0.05 && (peak_s - end_s).abs() < 0.03, "{frequency_ramp}: {peak_s} of {end_s}");
        }
    }

    #[test]
    fn most_power_is_the_logarithmic_frequency_ramps() {
        assert_eq!(greatest_power().unwrap().difference_text(), "none");
    }
}
