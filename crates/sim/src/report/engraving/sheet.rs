//! A sheet of pixels that keeps what dose each has had.

/// No side has many more pixels.
const PIXELS_MAX: f64 = 1_600.0;
/// No pixel is smaller, mm.
const PIXEL_MM_MIN: f64 = 0.05;
/// The beam is taken to be so wide where it is half as strong as in its middle, mm, or a pixel if that is more: rows as far apart
/// as a common diode's beam is wide engrave an area without gaps.
const SPOT_MM: f64 = 0.1;
/// Pixels in a row that a spot lights at most.
const LIT_MAX: usize = 4;

/// See the module.
pub struct Sheet {
    /// Row by row from the least Y on, duty times s.
    doses: Vec<f32>,
    width: usize,
    height: usize,
    /// The middle of the first pixel, X and Y.
    corner_mm: [f64; 2],
    /// The side of a pixel.
    pub pixel_mm: f64,
    /// From its middle to where a spot ends, pixels.
    spot: f64,
}

impl Sheet {
    /// A blank one for all within `extent_mm` of X and of Y, and the spots around; no pixel is smaller than `step_mm`.
    pub fn new(extent_mm: [(f64, f64); 2], step_mm: f64) -> Self {
        let [wide_mm, high_mm] = extent_mm.map(|(low, high)| high - low);
        let pixel_mm = (wide_mm.max(high_mm) / PIXELS_MAX).max(PIXEL_MM_MIN).max(step_mm);
        let spot = (SPOT_MM / pixel_mm).max(1.0);
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

    /// Adds a dose around a place: evenly less from the spot's middle to its end, both ways.
    pub fn add(&mut self, place_mm: [f64; 2], dose: f64) {
        let [(left, columns), (low, rows)] =
            [0, 1].map(|at| self.shares((place_mm[at] - self.corner_mm[at]) / self.pixel_mm));
        for (row, share) in (low..self.height).zip(rows) {
            let pixels = &mut self.doses[row * self.width..][..self.width];
            for (pixel, column) in pixels.iter_mut().skip(left).zip(columns) {
                *pixel += (dose * share * column) as f32;
            }
        }
    }

    /// The first pixel that a spot with this middle lights, and the shares of it and of those behind it: 1 together.
    fn shares(&self, middle: f64) -> (usize, [f64; LIT_MAX]) {
        let first = (middle - self.spot).floor() + 1.0;
        let shares: [f64; LIT_MAX] =
            std::array::from_fn(|index| (self.spot - (first + index as f64 - middle).abs()).max(0.0));
        let whole: f64 = shares.iter().sum();
        (first as usize, shares.map(|share| share / whole))
    }

    /// The dose that 99 % of the pixels that were lit do not exceed.
    pub fn strong(&self) -> f32 {
        let mut lit: Vec<f32> = self.doses.iter().copied().filter(|&dose| dose > 0.0).collect();
        let Some(last) = lit.len().checked_sub(1) else { return 0.0 };
        *lit.select_nth_unstable_by(last * 99 / 100, f32::total_cmp).1
    }

    /// Row by row from the top: white where no dose was, black where it was `strong` or more.
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
        let mut sheet = Sheet::new([(0.0, 20.0), (0.0, 10.0)], 0.07);
        for index in 0..100 {
            let part = f64::from(index) / 99.0;
            sheet.add([20.0 * part, 10.0 * part * part], 1.0);
        }
        let whole: f32 = sheet.doses.iter().sum();
        assert!((whole - 100.0).abs() < 1e-3, "{whole}");
    }

    /// Of steps and rows that do not fit the pixels an even grey comes.
    #[test]
    fn rows_as_far_apart_as_the_spot_is_wide_are_an_even_area() {
        let mut sheet = Sheet::new([(0.0, 8.0), (0.0, 8.0)], 0.0);
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
        let size = |side_mm: f64, step_mm: f64| Sheet::new([(0.0, side_mm), (0.0, side_mm / 2.0)], step_mm).size();
        assert_eq!((size(10.0, 0.0125), size(800.0, 0.0125)), ([205, 105], [1_603, 803]));
        assert_eq!(size(10.0, 0.5), [23, 13]);
    }

    #[test]
    fn black_is_what_hardly_any_pixel_exceeds() {
        let mut sheet = Sheet::new([(0.0, 100.0), (0.0, 0.0)], 1.0);
        (0..=100).for_each(|x| sheet.add([f64::from(x), 0.0], 1.0));
        sheet.add([50.0, 0.0], 99.0);
        assert_eq!(sheet.strong(), 1.0);
        let greys = sheet.greys(sheet.strong());
        assert_eq!(greys.iter().filter(|grey| **grey == 0).count(), 101);
        assert_eq!(greys.iter().filter(|grey| **grey == 255).count(), greys.len() - 101);
    }
}
