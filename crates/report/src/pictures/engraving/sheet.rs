//! A sheet of pixels that adds up the dose of each.

/// Approximate limit of the number of pixels per side.
const PIXELS_MAX: f64 = 1_600.0;
/// The smallest side of a pixel, mm.
const PIXEL_MM_MIN: f64 = 0.05;
/// The largest number of pixels in a row that a spot covers: a pixel is at least half as large as the beam is wide.
const LIT_MAX: usize = 4;

/// A sheet of pixels; see the module.
pub struct Sheet {
    /// Doses, duty times s, row by row from the least Y on.
    doses: Vec<f32>,
    width: usize,
    height: usize,
    /// The centre of the first pixel, X and Y.
    corner_mm: [f64; 2],
    /// The side of a pixel, mm.
    pub pixel_mm: f64,
    /// The radius of a spot, pixels.
    spot: f64,
}

impl Sheet {
    /// A blank sheet for all positions within `extent_mm` of X and Y, including the spots around them. No pixel is
    /// smaller than `step_mm`. The beam is `beam_mm` wide at half its maximum, but at least one pixel.
    pub fn new(extent_mm: [(f64, f64); 2], step_mm: f64, beam_mm: f64) -> Self {
        let [wide_mm, high_mm] = extent_mm.map(|(low, high)| high - low);
        let pixel_mm = (wide_mm.max(high_mm) / PIXELS_MAX).max(PIXEL_MM_MIN).max(step_mm).max(beam_mm / 2.0);
        let spot = (beam_mm / pixel_mm).max(1.0);
        let around = spot.ceil();
        let [width, height] = [wide_mm, high_mm].map(|mm| ((mm / pixel_mm).ceil() + 2.0 * around) as usize + 1);
        let corner_mm = extent_mm.map(|(low, _)| low - around * pixel_mm);
        Self { doses: vec![0.0; width * height], width, height, corner_mm, pixel_mm, spot }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The width of the spot, mm.
    pub fn spot_mm(&self) -> f64 {
        self.spot * self.pixel_mm
    }

    /// Adds a dose around a position. It decreases linearly from the centre of the spot to its edge in both directions.
    pub fn add(&mut self, place_mm: [f64; 2], dose: f64) {
        let [(left, columns), (low, rows)] =
            [0, 1].map(|at| self.ratios((place_mm[at] - self.corner_mm[at]) / self.pixel_mm));
        for (row, ratio) in (low..self.height).zip(rows) {
            let pixels = &mut self.doses[row * self.width..][..self.width];
            for (pixel, column) in pixels.iter_mut().skip(left).zip(columns) {
                *pixel += (dose * ratio * column) as f32;
            }
        }
    }

    /// The first pixel that a spot with this centre covers, and the fractions of the dose for it and the pixels after
    /// it; their sum is 1.
    fn ratios(&self, middle: f64) -> (usize, [f64; LIT_MAX]) {
        let first = (middle - self.spot).floor() + 1.0;
        let ratios: [f64; LIT_MAX] =
            std::array::from_fn(|index| (self.spot - (first + index as f64 - middle).abs()).max(0.0));
        let whole: f64 = ratios.iter().sum();
        (first as usize, ratios.map(|ratio| ratio / whole))
    }

    /// The 99th percentile of the dose of all pixels with a dose.
    pub fn strong(&self) -> f32 {
        let mut lit: Vec<f32> = self.doses.iter().copied().filter(|&dose| dose > 0.0).collect();
        let Some(last) = lit.len().checked_sub(1) else { return 0.0 };
        *lit.select_nth_unstable_by(last * 99 / 100, f32::total_cmp).1
    }

    /// Grey values row by row from the top: white without a dose, black with a dose of `strong` or more.
    pub fn greys(&self, strong: f32) -> Vec<u8> {
        let grey = |&dose: &f32| 255 - (dose / strong * 255.0).min(255.0).round() as u8;
        self.doses.chunks(self.width).rev().flatten().map(grey).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dose_is_kept_wherever_it_falls() {
        let mut sheet = Sheet::new([(0.0, 20.0), (0.0, 10.0)], 0.07, 0.1);
        for index in 0..100 {
            let part = f64::from(index) / 99.0;
            sheet.add([20.0 * part, 10.0 * part * part], 1.0);
        }
        let whole: f32 = sheet.doses.iter().sum();
        assert!((whole - 100.0).abs() < 1e-3, "{whole}");
    }

    /// The grey is even although steps and rows do not fit the pixels.
    #[test]
    fn rows_as_far_apart_as_the_spot_is_wide_are_an_even_area() {
        let mut sheet = Sheet::new([(0.0, 8.0), (0.0, 8.0)], 0.0, 0.1);
        for row in 0..=80 {
            (0..=320).for_each(|column| sheet.add([f64::from(column) * 0.025, f64::from(row) * 0.1], 1.0));
        }
        let inner =
            |pixel: usize| (10..150).contains(&(pixel % sheet.width)) && (10..150).contains(&(pixel / sheet.width));
        let doses = sheet.doses.iter().enumerate().filter(|(pixel, _)| inner(*pixel)).map(|(_, dose)| *dose);
        let (least, most) = doses.fold((f32::MAX, 0.0_f32), |(least, most), dose| (least.min(dose), most.max(dose)));
        assert!(most / least < 1.01, "{least} to {most}");
    }

    #[test]
    fn a_sheet_has_no_more_pixels_than_can_be_seen() {
        let size = |side_mm: f64, step_mm: f64| Sheet::new([(0.0, side_mm), (0.0, side_mm / 2.0)], step_mm, 0.1).size();
        assert_eq!((size(10.0, 0.0125), size(800.0, 0.0125)), ([205, 105], [1_603, 803]));
        assert_eq!(size(10.0, 0.5), [23, 13]);
    }

    #[test]
    fn black_is_what_hardly_any_pixel_exceeds() {
        let mut sheet = Sheet::new([(0.0, 100.0), (0.0, 0.0)], 1.0, 0.1);
        (0..=100).for_each(|x| sheet.add([f64::from(x), 0.0], 1.0));
        sheet.add([50.0, 0.0], 99.0);
        assert_eq!(sheet.strong(), 1.0);
        let greys = sheet.greys(sheet.strong());
        assert_eq!(greys.iter().filter(|grey| **grey == 0).count(), 101);
        assert_eq!(greys.iter().filter(|grey| **grey == 255).count(), greys.len() - 101);
    }
}
